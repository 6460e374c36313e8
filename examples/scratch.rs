use std::time::Instant;
use vesica::fem::*;
use vesica::linalg::*;
fn time(name: &str, n: usize, mut f: impl FnMut()) {
    for _ in 0..5 {
        f();
    }
    let mut best = f64::MAX;
    for _ in 0..n {
        let t = Instant::now();
        f();
        best = best.min(t.elapsed().as_secs_f64());
    }
    println!("{name}: min {:.3} ms", best * 1e3);
}
fn main() {
    for n in [60, 120, 240] {
        let mut c = CosineTransform::new(n);
        let m = c.multiplier(|k, l| 1.0 / (1.0 + (k + l) as f64));
        let size = (n + 1) * (n + 1);
        let x: Vec<f64> = (0..size).map(|i| (i as f64).sin()).collect();
        let mut y = vec![0.0; size];
        time(&format!("filter {n}"), 200, || c.filter(&m, &x, &mut y));
        let mesh = std::sync::Arc::new(Mesh::structured(n, 0.0, 0).unwrap());
        let s = Space::new(mesh, Rule::Consistent);
        time(&format!("spmv {n}"), 200, || {
            s.stiffness().multiply(&x, &mut y)
        });
        let mut z = y.clone();
        let k = s.stiffness().values.clone();
        let k2 = k.clone();
        time(&format!("both {n}"), 200, || {
            s.assembly()
                .pattern
                .multiply_both([&k, &k2], &x, &mut y, &mut z)
        });
        time(&format!("dot {n}"), 200, || {
            std::hint::black_box(vector::dot(&x, &y));
        });
        time(&format!("axpy {n}"), 200, || {
            vector::add_scaled(&mut y, 1e-9, &x)
        });
    }
    let a = faer::Mat::<f64>::from_fn(121, 121, |i, j| (i * j) as f64);
    let b = a.clone();
    let mut c = a.clone();
    time("gemm121", 100, || {
        faer::linalg::matmul::matmul(&mut c, faer::Accum::Replace, &a, &b, 1.0, faer::Par::Seq)
    });
    let a = faer::Mat::<f64>::from_fn(61, 61, |i, j| (i * j) as f64);
    let b = a.clone();
    let mut c = a.clone();
    time("gemm61", 100, || {
        faer::linalg::matmul::matmul(&mut c, faer::Accum::Replace, &a, &b, 1.0, faer::Par::Seq)
    });
    let a = faer::Mat::<f64>::from_fn(64, 64, |i, j| (i * j) as f64);
    let b = a.clone();
    let mut c = a.clone();
    time("gemm64", 100, || {
        faer::linalg::matmul::matmul(&mut c, faer::Accum::Replace, &a, &b, 1.0, faer::Par::Seq)
    });
    time("gemm64 bT", 100, || {
        faer::linalg::matmul::matmul(
            &mut c,
            faer::Accum::Replace,
            &a,
            b.transpose(),
            1.0,
            faer::Par::Seq,
        )
    });
    time("gemm64 aT", 100, || {
        faer::linalg::matmul::matmul(
            &mut c,
            faer::Accum::Replace,
            a.transpose(),
            &b,
            1.0,
            faer::Par::Seq,
        )
    });
}
