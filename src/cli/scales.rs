//! A scene in the numbers of a physicist: ratios of its lengths and times.

use crate::scene::{AnchoringKind, Geometry, Scene};
use crate::theory::relaxation_time;
use std::f64::consts::{PI, SQRT_2};

/// What is said of the scales of a scene whose vesicles together have this area, and one vesicle this reduced area 4πA/L².
pub(super) fn scales(scene: &Scene, enclosed: f64, reduced_area: Option<f64>) -> Vec<String> {
    let mut lines = Vec::new();
    if scene.geometry == Geometry::Axisymmetric {
        // They are those of a curve in the plane.
        return lines;
    }
    let epsilon = scene.membrane.interface_width;
    let radius = (enclosed / PI).sqrt();
    let tau = relaxation_time(enclosed, scene.membrane.mobility);
    let end = scene.time.end;
    let reduced = reduced_area.map_or(String::new(), |alpha| {
        format!(", reduced area 4πA/L² = {alpha:.3}")
    });
    lines.push(format!(
        "a circle of the vesicle's area has the radius R = {radius:.3}; ε/R = {:.3}{reduced}",
        epsilon / radius
    ));
    lines.push(format!(
        "its slowest mode relaxes in 2R⁵/(15 γ c) = {tau:.2e}, {} times time.end",
        short(tau / end)
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
            "extrapolation length of the anchoring K/W = {ratio:.2} ε = {:.3} R: {strength} anchoring",
            ratio * epsilon / radius
        ));
    }
    let order_length = nematic.penalty / SQRT_2;
    lines.push(format!(
        "the length of the director recovers over η_d/√2 = {order_length:.3} = {:.1} ε = {:.2} R, the core of a defect",
        order_length / epsilon,
        order_length / radius
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
        10.0.. => format!("{value:.0}"),
        _ => crate::scene::significant(value, 2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 1: 14 T, 1.06 ε, 0.053.
    #[test]
    fn the_paper_s_scene_has_its_numbers() {
        let scene = Scene::of_text("[nematic]\n[anchoring]\n", &[]);
        let words = scales(&scene, PI * 0.0625, Some(0.69)).join("\n");
        for part in [
            "R = 0.250; ε/R = 0.040, reduced area 4πA/L² = 0.690",
            "relaxes in 2R⁵/(15 γ c) = 1.38e-2, 14 times time.end",
            "K/W = 1.06 ε = 0.042 R: strong",
            "η_d/√2 = 0.053 = 5.3 ε = 0.21 R",
        ] {
            assert!(words.contains(part), "{part}\n{words}");
        }
        let bare = Scene::of_text("time.end = 1.0", &[]);
        let words = scales(&bare, PI * 0.0625, None);
        assert_eq!(words.len(), 2, "{words:?}");
        assert!(words[1].contains("0.014 times time.end"), "{words:?}");
    }
}
