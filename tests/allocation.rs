//! A step allocates nothing once a run is under way: a counting allocator watches `Scheme::step`.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

#[expect(dead_code, reason = "only its effect is used")]
#[path = "../examples/own_effect.rs"]
mod own_effect;

use common::{SMALL, scene, scheme};
use vesica::internal::scheme::SchemeCheckpoint;
use vesica::{Effect, Patch, PatchFields, Room, Scheme};

/// The system's allocator, which counts what each thread asks of it.
struct Counting;

thread_local! {
    /// Allocations of this thread. Constant at the start and without a destructor, so that the
    /// allocator may use it at any time.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
    /// Bytes of a field, and how many blocks of at least that size were taken.
    static FIELD: Cell<usize> = const { Cell::new(usize::MAX) };
    static FIELDS: Cell<u64> = const { Cell::new(0) };
    /// Bytes that are held, and the most of them.
    static HELD: Cell<isize> = const { Cell::new(0) };
    static MOST: Cell<isize> = const { Cell::new(0) };
}

fn hold(bytes: isize) {
    let held = HELD.with(Cell::get) + bytes;
    HELD.with(|cell| cell.set(held));
    MOST.with(|most| most.set(most.get().max(held)));
}

fn count(size: usize) {
    hold(size as isize);
    if size >= FIELD.with(Cell::get) {
        FIELDS.with(|fields| fields.set(fields.get() + 1));
    }
    ALLOCATIONS.with(|allocations| allocations.set(allocations.get() + 1));
}

// SAFETY: every call is handed to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size());
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        hold(-(layout.size() as isize));
        count(size);
        // SAFETY: as above.
        unsafe { System.realloc(block, layout, size) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        hold(-(layout.size() as isize));
        // SAFETY: as above.
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// How often `work` allocates.
fn allocations(work: impl FnOnce()) -> u64 {
    let before = ALLOCATIONS.with(Cell::get);
    work();
    ALLOCATIONS.with(Cell::get) - before
}

/// Steps after which everything has its size: the history of the extrapolation is full.
const WARM_UP: usize = 5;
const STEPS: usize = 10;

/// Allocations of each step after the first ones.
fn allocations_of_steps(settings: &[&str], prepare: impl FnOnce(&mut Scheme)) -> Vec<u64> {
    let scene = scene(SMALL, settings);
    let mut scheme = scheme(&scene);
    prepare(&mut scheme);
    let mut counts = Vec::with_capacity(STEPS);
    for step in 1..=WARM_UP + STEPS {
        let count = allocations(|| {
            if let Err(error) = scheme.step(scene.time.step) {
                panic!("{settings:?} step {step}: {error}");
            }
        });
        if step > WARM_UP {
            counts.push(count);
        }
    }
    counts
}

/// How many blocks as long as a field, or longer, are taken until a scheme has made its first step.
fn fields_of(settings: &[&str]) -> u64 {
    let scene = scene(SMALL, settings);
    let nodes = common::mesh(&scene).nodes().len();
    FIELD.with(|field| field.set(nodes * size_of::<f64>()));
    let before = FIELDS.with(Cell::get);
    let mut scheme = scheme(&scene);
    if let Err(error) = scheme.step(scene.time.step) {
        panic!("{settings:?}: {error}");
    }
    FIELDS.with(Cell::get) - before
}

/// An effect that is not there, or is of the kind "none", takes no vector; one that is there does.
#[test]
fn an_absent_effect_takes_no_vector() {
    for quadrature in ["solver.quadrature=consistent", "solver.quadrature=lumped"] {
        let of = |settings: &[&str]| fields_of(&[&[quadrature], settings].concat());
        let bending = ["area=false", "anchoring=false", "nematic=false"];
        let alone = of(&bending);
        let with = |more: &[&str]| of(&[&bending[..], more].concat());
        assert_eq!(with(&["membrane.spontaneous_curvature=0"]), alone);
        assert!(with(&["membrane.spontaneous_curvature=1"]) > alone);
        assert!(with(&["pull.potential=1"]) > alone);
        let area = of(&["anchoring=false", "nematic=false"]);
        assert!(area > alone);
        let nematic = of(&["anchoring=false"]);
        assert!(nematic >= area + 10, "{nematic} {area}");
        assert_eq!(of(&["anchoring.kind=none"]), nematic);
        assert!(of(&[]) > nematic);
    }
}

/// The memory that the making of a mesh takes is that of its nodes, also where the longest edges are
/// thousands of times the shortest, and a run of the scene is foreseen to need more.
#[test]
fn a_graded_mesh_is_made_in_the_memory_of_its_nodes() {
    let text = "
        mesh = { kind = 'delaunay', size = 0.25, refine = { band = 1e-4, size = 5e-5 } }
        membrane = { interface_width = 0.03 }
        vesicle = { shape = 'circle', radius = 0.01 }
    ";
    let scene = scene(text, &[] as &[&str]);
    let before = HELD.with(Cell::get);
    MOST.with(|most| most.set(before));
    let nodes = common::mesh(&scene).nodes().len();
    let bytes = (MOST.with(Cell::get) - before) as f64;
    let expected = vesica::internal::simulation::node_count(&scene);
    assert!(
        (expected / nodes as f64 - 1.0).abs() < 0.1,
        "{expected} {nodes}"
    );
    assert!(bytes / (nodes as f64) < 1500.0, "{bytes} for {nodes} nodes");
    let foreseen = vesica::internal::simulation::memory_needed(&scene) as f64;
    assert!(bytes < foreseen, "{bytes} {foreseen}");
}

/// An effect that does nothing, and of which nobody knows where it acts on the director: with it substep
/// 1 is solved on the whole mesh.
#[derive(Debug)]
struct Anywhere;

impl Effect for Anywhere {
    fn name(&self) -> &'static str {
        "anywhere"
    }

    fn integral(&self, _: &Patch<'_>, _: &PatchFields, _: &mut Room) -> f64 {
        0.0
    }

    fn has_energy(&self) -> bool {
        false
    }
}

/// The matrices and vectors of substep 1 are those of its region. The region has a mesh of its own,
/// which takes a good part of what is saved with lumped quadrature, and more than all of it with
/// consistent quadrature, whose points it has too: what it saves there is time. How much it is in case 3 is
/// printed.
#[test]
fn a_region_holds_less_than_the_whole_mesh_with_lumped_quadrature() {
    let case3 = vesica::find_preset("case3").expect("it is built in");
    let held = |everywhere: bool| {
        let scene = scene(case3, &["solver.quadrature=lumped", "mesh.cells=60"]);
        let before = HELD.with(Cell::get);
        let mut scheme = scheme(&scene);
        if everywhere {
            scheme.effects_mut().add(Anywhere);
        }
        scheme.step(scene.time.step).expect("a step");
        (HELD.with(Cell::get) - before) as f64 / 1e6
    };
    // What is made once and kept, whatever is run first.
    held(false);
    let [part, whole] = [false, true].map(held);
    println!("{part:.2} MB, {whole:.2} everywhere");
    assert!(part < whole, "{part} {whole}");
}

/// Where the region of substep 1 becomes another one its space and its matrices are rebuilt: such steps
/// allocate, and are few. How few in case 3 is printed.
#[test]
fn only_a_step_with_a_new_region_allocates() {
    const STEPS: usize = 60;
    let case3 = vesica::find_preset("case3").expect("it is built in");
    let settings = ["solver.quadrature=lumped", "mesh.cells=60"];
    let scene = scene(case3, &settings);
    let mut scheme = scheme(&scene);
    let mut steps = 0;
    for step in 1..=WARM_UP + STEPS {
        let count = allocations(|| {
            scheme.step(scene.time.step).expect("a step");
        });
        steps += usize::from(step > WARM_UP && count > 0);
    }
    println!("{steps} of {STEPS} steps have allocated");
    assert!(steps < STEPS / 4, "{steps}");
}

#[test]
fn the_allocator_counts() {
    let mut kept = Vec::new();
    assert_eq!(allocations(|| kept.push(1_u8)), 1);
    assert_eq!(allocations(|| kept.extend([0; 1000])), 1);
    assert_eq!(allocations(|| kept.clear()), 0);
}

#[test]
fn a_step_allocates_nothing() {
    for quadrature in ["solver.quadrature=consistent", "solver.quadrature=lumped"] {
        for path in [
            "solver.linear=transform",
            "solver.linear=shifted",
            "mesh.jitter=0.2",
            "solver.linear=factor",
            "domain.boundary=clamped",
            "solver.iteration=lagged",
            "anchoring.kind=homeotropic",
            "anchoring.kind=none",
            "membrane.spontaneous_curvature=1.5",
            "field.weight=300",
            "field.weight=-300",
            "pull.potential='100*x'",
            "noise={ strength = 1e-4 }",
        ] {
            let counts = allocations_of_steps(&[quadrature, path], |_| {});
            assert_eq!(counts, [0; STEPS], "{quadrature}, {path}");
        }
        let example = own_effect::Tension { weight: 3.0 };
        let counts = allocations_of_steps(&[quadrature], |scheme| scheme.add_effect(example));
        assert_eq!(counts, [0; STEPS], "{quadrature}, a line tension");
    }
}

#[test]
fn a_state_is_remembered_and_recalled_without_allocation() {
    for path in [
        "solver.linear=transform",
        "solver.linear=shifted",
        "solver.linear=factor",
    ] {
        let scene = scene(SMALL, &[path]);
        let mut scheme = scheme(&scene);
        let mut memory = SchemeCheckpoint::default();
        let step = |scheme: &mut Scheme| {
            scheme.step(scene.time.step).expect("a step");
        };
        (0..WARM_UP).for_each(|_| step(&mut scheme));
        scheme.save(&mut memory);
        for _ in 0..STEPS {
            let count = allocations(|| {
                step(&mut scheme);
                scheme.restore(&memory).expect("the same scheme");
                step(&mut scheme);
                scheme.save(&mut memory);
            });
            assert_eq!(count, 0, "{path}");
        }
    }
}
