//! The viewing matrices against projections done by hand.

use crate::oracle::Poly;
use crate::oracle::coverage::framebuffer;
use crate::oracle::judge;
use crate::oracle::probe::{self, View};
use crate::oracle::shapes::{Tally, check};
use glam::DVec3;
use hyperspan::camera::{self, DepthConvention, DepthPlanes};
use hyperspan::space::{DepthRange, Viewport};
use proptest::prelude::*;

fn planes() -> impl Strategy<Value = DepthPlanes> {
    let convention = prop_oneof![Just(DepthConvention::Reversed), Just(DepthConvention::Standard)];
    let range = prop_oneof![Just(DepthRange::ZeroToOne), Just(DepthRange::MinusOneToOne)];
    (0.01..1.0_f64, 2.0..100.0_f64, convention, range)
        .prop_map(|(near, far, convention, range)| DepthPlanes { near, far, convention, range })
}

/// Depth as the framebuffer has it.
fn depth(planes: DepthPlanes, [_, _, z, w]: [f64; 4]) -> f64 {
    match planes.range {
        DepthRange::ZeroToOne => z / w,
        DepthRange::MinusOneToOne => (z / w + 1.0) / 2.0,
    }
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * (1.0 + b.abs())
}

#[test]
fn cameras_with_intrinsics_put_points_where_a_pinhole_does() {
    let focal = [100.0..2000.0_f64, 100.0..2000.0];
    let middle = [-300.0..900.0_f64, -300.0..900.0];
    let point = (-9.0..9.0_f64, -9.0..9.0_f64, 0.1..50.0_f64);
    let strategy = (focal, middle, (1..2000_u32, 1..2000_u32), point, planes());
    check(file!(), "cameras_intrinsics", 2000, &strategy, |(f, c, (w, h), (x, y, z), planes)| {
        let matrix = camera::intrinsics(f[0], f[1], c[0], c[1], w, h, planes).expect("a camera");
        let p = camera::transform(matrix, DVec3::new(x, -y, -z));
        let at = framebuffer(Viewport::new(0, 0, w, h).expect("small"), p);
        // OpenCV's y points down, its z away from the eye, and its pixel 0 has its centre at 0.
        prop_assert!(close(at[0], f[0] * x / z + c[0] + 0.5), "{:?}", at);
        prop_assert!(close(at[1], f[1] * y / z + c[1] + 0.5), "{:?}", at);
        prop_assert!(close(p[3], z));
        Ok(())
    });
}

#[test]
fn cameras_off_centre_see_their_window() {
    let side = || (-3.0..3.0_f64, 0.1..3.0_f64).prop_map(|(low, size)| [low, low + size]);
    let strategy = (side(), side(), [0.0..1.0_f64, 0.0..1.0, 0.0..1.0], planes());
    check(file!(), "cameras_off_centre", 2000, &strategy, |(x, y, [s, t, u], planes)| {
        let viewport = Viewport::new(0, 0, 100, 50).expect("small");
        let window = [x[0] + s * (x[1] - x[0]), y[0] + t * (y[1] - y[0])];
        let wanted = [100.0 * s, 50.0 * (1.0 - t)];
        let (near, far) = (planes.near, planes.far);
        let distance = near + u * (far - near);
        // Through a point of the window on the near plane, any distance away.
        let matrix = camera::frustum(x[0], x[1], y[0], y[1], planes).expect("a camera");
        let scale = distance / near;
        let p =
            camera::transform(matrix, DVec3::new(window[0] * scale, window[1] * scale, -distance));
        let at = framebuffer(viewport, p);
        prop_assert!(close(at[0], wanted[0]) && close(at[1], wanted[1]), "frustum {:?}", at);
        prop_assert!(close(p[3], distance));
        let standard = (1.0 - near / distance) / (1.0 - near / far);
        let reversed = planes.convention == DepthConvention::Reversed;
        let right = if reversed { 1.0 - standard } else { standard };
        prop_assert!(close(depth(planes, p), right), "{} for {}", depth(planes, p), right);
        // Straight on.
        let matrix = camera::orthographic(x[0], x[1], y[0], y[1], planes).expect("a camera");
        let p = camera::transform(matrix, DVec3::new(window[0], window[1], -distance));
        let at = framebuffer(viewport, p);
        prop_assert!(close(at[0], wanted[0]) && close(at[1], wanted[1]), "ortho {:?}", at);
        prop_assert_eq!(p[3], 1.0);
        let right = if reversed { 1.0 - u } else { u };
        prop_assert!(close(depth(planes, p), right), "{} for {}", depth(planes, p), right);
        Ok(())
    });
}

/// The near plane as near as f64 has it, the far one at infinity: a floor is drawn up to the
/// horizon, with the right depths, and nothing of the picture depends on the near plane but
/// depth.
#[test]
fn cameras_see_from_nearly_zero_to_infinity() {
    let exponent = prop_oneof![0..60_i32, 0..1000_i32];
    // Not so wide that the nearest near plane cuts into the floor.
    let strategy = (exponent, planes(), -20.0..20.0_f64, 20.0..85.0_f64);
    let pixels = Tally::default();
    let cases = check(file!(), "cameras_near_and_far", 200, &strategy, |(e, planes, side, fov)| {
        let near = f64::from(-e).exp2();
        let planes = DepthPlanes { near, far: f64::INFINITY, ..planes };
        let viewport = Viewport::new(0, 0, 16, 16).expect("small").with_depth_range(planes.range);
        let draw = |planes: DepthPlanes| {
            let matrix = camera::perspective(fov, 1.0, planes).expect("a camera");
            let columns = matrix.to_cols_array_2d();
            let clip = |p: [f64; 4]| {
                [0, 1, 2, 3].map(|r| (0..4).map(|c| columns[c][r] * p[c]).sum::<f64>())
            };
            // Two corners behind the eye, two at infinity.
            let floor = [
                clip([side - 90.0, -1.0, 9.0, 1.0]),
                clip([side + 90.0, -1.0, 9.0, 1.0]),
                clip([40.0, 0.0, -1.0, 0.0]),
                clip([-40.0, 0.0, -1.0, 0.0]),
            ];
            let poly = Poly::bare(&floor);
            let view = View::whole(viewport);
            let picture = probe::draw(&view, &poly).1;
            (view, poly, picture)
        };
        let (view, poly, picture) = draw(planes);
        judge::coverage(&view, &poly, &picture).map_err(TestCaseError::fail)?;
        judge::values(&view, &poly, &picture).map_err(TestCaseError::fail)?;
        prop_assert_eq!(picture.len(), 16 * 8, "all below the horizon");
        pixels.add(picture.len());
        let others = draw(DepthPlanes { near: near / 2.0, ..planes }).2;
        for (place, seen) in &picture {
            prop_assert_eq!((seen.w, seen.inv_w), (others[place].w, others[place].inv_w));
        }
        Ok(())
    });
    pixels.report("pixels", 100 * cases);
}
