use vesica::fem::*;
fn main() {
    let n = 120;
    let size = (n + 1) * (n + 1);
    let x: Vec<f64> = (0..size).map(|i| (i as f64).sin()).collect();
    let mut y = vec![0.0; size];
    let mesh = std::sync::Arc::new(Mesh::structured(n, 0.0, 0).unwrap());
    let s = Space::new(mesh, Rule::Lumped);
    for _ in 0..20000 {
        s.stiffness().multiply(&x, &mut y);
    }
}
