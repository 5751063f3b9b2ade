use super::super::test_scene::scene;
use super::*;

#[test]
fn two_patches_as_written_out() {
    // F = ((0, 1/2), (1/4, 0)), R = diag(1/2, 1/5): two bounces add F R F, three F R F R F.
    let (f, r) = ([0.0, 0.5, 0.25, 0.0], [[0.5f32; 3], [0.2; 3]]);
    assert_eq!(polynomial(&f, 2, &r, 0).unwrap()[0], [0.0; 4]);
    assert_eq!(polynomial(&f, 2, &r, 1).unwrap()[1], f);
    assert_eq!(polynomial(&f, 2, &r, 2).unwrap()[2], [0.025, 0.5, 0.25, 0.0625]);
    assert_eq!(polynomial(&f, 2, &r, 3).unwrap()[0], [0.025, 0.50625, 0.253125, 0.0625]);
    // Closed form: (I - R F)^-1 has determinant 1 - 1/80.
    let all = resolvent(&f, 2, &r).unwrap();
    let wanted = [0.025, 0.5, 0.25, 0.0625].map(|x| x / (1.0 - 1.0 / 80.0));
    all[0].iter().zip(wanted).for_each(|(a, b)| assert!((f64::from(*a) - b).abs() < 1e-7, "{a} {b}"));
}

/// A furnace: rows sum to 1 and reflectance is 0.5 everywhere, so that rows of the resolvent sum to 2; many terms are the same as all of them.
#[test]
fn resolvent_is_the_polynomial_without_end() {
    let scene = scene(4, 2);
    let grey = vec![[0.5, 0.9, 0.0]; scene.n];
    let all = resolvent(&scene.factors, scene.n, &grey).unwrap();
    let many = polynomial(&scene.factors, scene.n, &grey, 40).unwrap();
    let most = all[0].iter().copied().fold(0.0, f32::max);
    all[0].iter().zip(&many[0]).for_each(|(a, b)| assert!((a - b).abs() < 1e-5 * most, "{a} {b}"));
    assert_eq!(all[2], scene.factors);
    for (row, factors) in all[0].chunks(scene.n).zip(scene.factors.chunks(scene.n)) {
        if factors.iter().sum::<f32>() > 0.0 {
            assert!((row.iter().sum::<f32>() - 2.0).abs() < 1e-3, "{}", row.iter().sum::<f32>());
        }
    }
}

#[test]
fn what_does_not_fit_or_diverges_is_an_error() {
    for n in [0, 1, 3, 5] {
        let sums = vec![1.0 / n.max(1) as f32; n * n];
        assert_eq!(polynomial(&sums, n, &vec![[0.5; 3]; n], 3).unwrap()[0].len(), n * n);
        assert_eq!(resolvent(&sums, n, &vec![[0.5; 3]; n]).unwrap()[0].len(), n * n);
        assert!(polynomial(&sums, n + 1, &vec![[0.5; 3]; n + 1], 3).is_err());
        assert!(resolvent(&sums, n, &vec![[0.5; 3]; n + 1]).is_err());
        if n > 0 {
            let error = resolvent(&sums, n, &vec![[0.5, 1.0, 0.5]; n]).unwrap_err();
            assert!(error.contains("channel 1"), "{error}");
            assert!(resolvent(&sums, n, &vec![[3.0; 3]; n]).is_err());
        }
    }
    assert!(polynomial(&[f32::NAN], 1, &[[0.5; 3]], 2).is_err());
    assert!(polynomial(&[0.0], usize::MAX, &[], 2).is_err());
}
