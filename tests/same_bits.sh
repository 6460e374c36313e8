#!/usr/bin/env bash
# Does a program still compute the same bits?
#
#     tests/same_bits.sh target/release/vesica > before
#     …change the code, build…
#     tests/same_bits.sh target/release/vesica | diff before -
#
# Runs short scenes over what a scene may ask for, and prints one line a scene: a hash of history.csv without its column
# `wall`, of ledger.csv, of shape.csv, and of all fields. A scene that fails is a line with its exit status.
set -euo pipefail

program=$(realpath "${1:?the program, such as target/release/vesica}")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

without_wall() {
    awk -F, -v OFS=, 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == "wall") wall = i } { $wall = ""; print }' "$1"
}

hash() { sha256sum | cut -c1-16; }

# run NAME PRESET END [KEY=VALUE]...: END is a number of steps, or a time where steps are chosen
run() {
    local name=$1 preset=$2 end=$3
    shift 3
    local settings=(--set membrane.interface_width=0.03)
    local setting
    for setting in "$@"; do settings+=(--set "$setting"); done
    local status=0
    case $end in
        *e*) settings+=(--until "$end") ;;
        *) settings+=(--steps "$end") ;;
    esac
    "$program" run "$preset" --out "$name" "${settings[@]}" >"$name.log" 2>&1 || status=$?
    if [ "$status" != 0 ]; then
        echo "$name: exit status $status: $(tail -n 1 "$name.log")"
        return
    fi
    local fields
    fields=$(find "$name" -name '*.vtu' | sort | xargs cat | hash)
    echo "$name: history $(without_wall "$name/history.csv" | hash) ledger $(hash <"$name/ledger.csv")" \
        "shape $(hash <"$name/shape.csv") fields $fields"
}

small="mesh.cells=40"
delaunay=(mesh.kind=delaunay mesh.size=0.03)
graded=(mesh.kind=delaunay mesh.size=0.06 'mesh.refine={ band = 0.08, size = 0.02 }')

# Boundaries, anchorings, quadratures, iterations.
run consistent case3 8 $small
run lumped case4 8 $small solver.quadrature=lumped
run parallel case1 8 $small anchoring.kind=parallel
run none case2 8 $small anchoring.kind=none
run lagged case3 8 $small solver.iteration=lagged
run clamped case3 8 $small domain.boundary=clamped
run clamped-lumped case3 8 $small domain.boundary=clamped solver.quadrature=lumped

# Linear solvers, meshes, projections.
run transform case3 8 $small solver.linear=transform time.step=1e-5
run shifted case3 8 $small solver.linear=shifted
run factor case3 8 $small solver.linear=factor time.step=1e-5
run automatic case3 6 $small time.step=1e-4
run jitter case3 8 $small mesh.jitter=0.2 vesicle.projection=l2
run delaunay case4 8 "${delaunay[@]}"
run delaunay-lumped case4 8 "${delaunay[@]}" solver.quadrature=lumped vesicle.projection=nodal
run graded case3 8 "${graded[@]}"

# Chosen steps.
run chosen-first-order case3 2e-6 $small time.tolerance=1e-2 time.scheme=first-order
run secant-fixed case3 2e-6 $small time.scheme=secant
run chosen case3 2e-6 $small time.tolerance=1e-2
run chosen-graded case4 2e-6 "${graded[@]}" time.tolerance=3e-3
run chosen-lumped case4 2e-6 $small time.tolerance=3e-3 solver.quadrature=lumped

# Effects, shapes, directors.
run bending bending 8 $small
run curvature curvature 8 $small
run curvature-varies case3 8 $small "membrane.spontaneous_curvature='2*sin(3*x) - y'"
run field field 8 $small field.from=4e-7
run pull pull 8 $small
run noise noise 8 $small
run noise-consistent noise 4 $small solver.quadrature=consistent noise.strength=1e-6
run everything case3 8 $small 'field={ weight = 300, angle = 35, from = 3e-7 }' "pull.potential='100*x - 300*y^2'" \
    'noise={ strength = 1e-6, seed = 5 }' membrane.spontaneous_curvature=1.5
run without-director case3 8 $small anchoring=false nematic=false
run defects case3 8 $small 'nematic.initial={ kind = "defects", at = [{ center = [0.5, 0.5], winding = 1.0 }] }'
run random-director case3 8 $small 'nematic.initial={ kind = "random", seed = 3, length = 1.2 }'
run random-phase case3 4 $small 'vesicle={ shape = "random", amplitude = 0.5, seed = 2 }' time.step=1e-6
run two-vesicles case3 8 $small \
    'vesicle={ parts = [{ shape = "circle", radius = 0.15, center = [0.3, 0.5] }, { shape = "ellipse", half_axes = [0.2, 0.1], center = [0.7, 0.5], angle = 90 }] }'
run discocyte case1 8 $small 'vesicle={ shape = "discocyte", radius = 0.3, angle = 30 }'
run hard-step case3 1 $small time.step=1e-2
