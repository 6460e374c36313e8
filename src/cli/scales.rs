//! A scene in the numbers of a physicist: ratios of its lengths and times.

use crate::scene::{AnchoringKind, Geometry, Scene, significant};
use crate::theory::{relaxation_time, relaxation_time_of_sphere};
use std::f64::consts::{PI, SQRT_2};

/// What is said of the scales of a scene whose vesicles together have the area of a circle of this radius, and one vesicle this
/// reduced area; by rotation the volume of a sphere, and a reduced volume.
pub(super) fn scales(scene: &Scene, radius: f64, reduced_size: Option<f64>) -> Vec<String> {
    let mut lines = Vec::new();
    let epsilon = scene.membrane.interface_width;
    let mobility = scene.membrane.mobility;
    let (round, reduced, time, tau) = match scene.geometry {
        Geometry::Planar => (
            "circle of the vesicle's area",
            "reduced area 4πA/L²",
            "2R⁵/(15 γ c)",
            relaxation_time(PI * radius * radius, mobility),
        ),
        Geometry::Axisymmetric => (
            "sphere of the vesicle's volume",
            "reduced volume",
            "R⁵/(30 γ c)",
            relaxation_time_of_sphere(radius, mobility),
        ),
    };
    let reduced = reduced_size.map_or(String::new(), |size| {
        format!(", {reduced} = {size:.3} at the start")
    });
    lines.push(format!(
        "a {round} has the radius R = {radius:.3}; ε/R = {:.3}{reduced}",
        epsilon / radius
    ));
    lines.push(format!(
        "its slowest mode relaxes in {time} = {tau:.2e}, {} times time.end",
        short(tau / scene.time.end)
    ));
    let Some(nematic) = scene.nematic.as_ref() else {
        return lines;
    };
    let anchoring = scene
        .anchoring
        .filter(|it| it.kind != AnchoringKind::None && it.weight > 0.0);
    if let Some(anchoring) = anchoring {
        // K/W_a with K = λ_nem and W_a = λ_anch 2√2/(3ε), the limit of E_anch a unit of length.
        let ratio = extrapolation_length(nematic.weight, anchoring.weight);
        let strength = if ratio * epsilon < radius {
            "strong"
        } else {
            "weak"
        };
        lines.push(format!(
            "extrapolation length of the anchoring K/W = {} ε = {} R: {strength} anchoring",
            significant(ratio, 3),
            significant(ratio * epsilon / radius, 2)
        ));
    }
    let order_length = nematic.penalty / SQRT_2;
    lines.push(format!(
        "the length of the director recovers over η_d/√2 = {} = {} ε = {} R, the core of a defect",
        significant(order_length, 2),
        significant(order_length / epsilon, 2),
        significant(order_length / radius, 2)
    ));
    lines
}

/// K/(W_a ε) = 3 λ_nem/(2√2 λ_anch).
fn extrapolation_length(nematic: f64, anchoring: f64) -> f64 {
    3.0 / (2.0 * SQRT_2) * nematic / anchoring
}

/// In two or three digits.
fn short(value: f64) -> String {
    match value {
        10.0..1e6 => format!("{value:.0}"),
        _ => significant(value, 2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 1: 14 T, 1.06 ε, 0.053.
    #[test]
    fn the_paper_s_scene_has_its_numbers() {
        let scene = Scene::of_text("[nematic]\n[anchoring]\n", &[]);
        let words = scales(&scene, 0.25, Some(0.69)).join("\n");
        for part in [
            "R = 0.250; ε/R = 0.040, reduced area 4πA/L² = 0.690",
            "relaxes in 2R⁵/(15 γ c) = 1.38e-2, 14 times time.end",
            "K/W = 1.06 ε = 0.042 R: strong",
            "η_d/√2 = 0.053 = 5.3 ε = 0.21 R",
        ] {
            assert!(words.contains(part), "{part}\n{words}");
        }
        let bare = Scene::of_text("time.end = 1.0", &[]);
        let words = scales(&bare, 0.25, None);
        assert_eq!(words.len(), 2, "{words:?}");
        assert!(words[1].contains("0.014 times time.end"), "{words:?}");
        let text = "domain.geometry = \"axisymmetric\"\nvesicle.center = [0.0, 0.5]";
        let words = scales(&Scene::of_text(text, &[]), 0.25, Some(0.64)).join("\n");
        // A quarter of the time of the circle.
        for part in ["reduced volume = 0.640", "R⁵/(30 γ c) = 3.45e-3, 3.5 times"] {
            assert!(words.contains(part), "{part}\n{words}");
        }
    }
}
