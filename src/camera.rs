//! The viewing matrices (Shirley and others, chapter 7), in `f64`, on `glam`'s types.
//!
//! Right-handed; the eye looks down -z of its space, y is up; clip space has y up and w the
//! distance along the view axis (1 for orthographic cameras). Multiply as
//! `projection * view * model * position`, or with [`transform`], whose bits do not depend on
//! how `glam` was built. No function of the platform is called.

use glam::{DMat4, DVec3, DVec4};

use crate::error::Error;
use crate::space::DepthRange;

/// Where depth 0 and 1 lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DepthConvention {
    /// 1 at the near plane, 0 at the far one or at infinity: `f32` keeps its precision far away.
    #[default]
    Reversed,
    /// 0 at the near plane, 1 at the far one.
    Standard,
}

/// The depths between which a camera sees, and how they become clip-space z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthPlanes {
    /// Distance of the near plane along the view axis.
    pub near: f64,
    /// Distance of the far plane; `f64::INFINITY` is fine for perspective cameras.
    pub far: f64,
    /// Which end is 1.
    pub convention: DepthConvention,
    /// The range of z in clip space; the viewport must have the same.
    pub range: DepthRange,
}

impl DepthPlanes {
    /// (a, b) such that z = a d + b at distance d, w = d, for a perspective camera.
    fn perspective_row(self) -> Result<(f64, f64), Error> {
        let (n, f) = (self.near, self.far);
        let ordered = n > 0.0 && n < f && n.is_finite();
        if !ordered {
            return Err(Error::Camera("the planes must be 0 < near < far, near finite"));
        }
        let infinite = f == f64::INFINITY;
        let (a, b) = match self.convention {
            DepthConvention::Standard if infinite => (1.0, -n),
            DepthConvention::Standard => (f / (f - n), -(n * (f / (f - n)))),
            DepthConvention::Reversed if infinite => (0.0, n),
            DepthConvention::Reversed => (-(n / (f - n)), f * (n / (f - n))),
        };
        Ok(match self.range {
            DepthRange::ZeroToOne => (a, b),
            DepthRange::MinusOneToOne => (2.0 * a - 1.0, 2.0 * b),
        })
    }

    /// (a, b) such that z = a d + b at distance d, w = 1, for an orthographic camera.
    fn orthographic_row(self) -> Result<(f64, f64), Error> {
        let (n, f) = (self.near, self.far);
        let ordered = n < f && (f - n).is_finite();
        if !ordered {
            return Err(Error::Camera("the planes must be near < far, both finite"));
        }
        let (a, b) = match self.convention {
            DepthConvention::Standard => (1.0 / (f - n), -(n / (f - n))),
            DepthConvention::Reversed => (-(1.0 / (f - n)), f / (f - n)),
        };
        Ok(match self.range {
            DepthRange::ZeroToOne => (a, b),
            DepthRange::MinusOneToOne => (2.0 * a, 2.0 * b - 1.0),
        })
    }
}

/// World to eye space: the eye at `eye`, `target` in the middle, `up` towards the top.
///
/// # Errors
/// [`Error::Camera`] if `eye` and `target` are the same, or `up` points along the view.
pub fn look_at(eye: DVec3, target: DVec3, up: DVec3) -> Result<DMat4, Error> {
    let same = Error::Camera("eye and target must be different, finite points");
    let forward = unit(sub(target, eye)).ok_or(same)?;
    let along = Error::Camera("up must not point along the view");
    let right = unit(cross(forward, up)).ok_or(along)?;
    let up = cross(right, forward);
    Ok(rows([
        [right.x, right.y, right.z, -dot(right, eye)],
        [up.x, up.y, up.z, -dot(up, eye)],
        [-forward.x, -forward.y, -forward.z, dot(forward, eye)],
        [0.0, 0.0, 0.0, 1.0],
    ]))
}

/// Eye to clip space: a symmetric perspective with a vertical field of view.
///
/// # Errors
/// [`Error::Camera`] unless `0 < fov_y_degrees < 180`, `aspect` (width over height) is positive
/// and `0 < near < far`.
pub fn perspective(fov_y_degrees: f64, aspect: f64, planes: DepthPlanes) -> Result<DMat4, Error> {
    let valid = fov_y_degrees > 0.0 && fov_y_degrees < 180.0;
    if !valid {
        return Err(Error::Camera("the field of view must lie between 0 and 180 degrees"));
    }
    let shape = aspect > 0.0 && aspect < f64::INFINITY;
    if !shape {
        return Err(Error::Camera("the aspect ratio must be positive"));
    }
    let scale = 1.0 / libm::tan(fov_y_degrees.to_radians() / 2.0);
    let (a, b) = planes.perspective_row()?;
    Ok(rows([
        [scale / aspect, 0.0, 0.0, 0.0],
        [0.0, scale, 0.0, 0.0],
        [0.0, 0.0, -a, b],
        [0.0, 0.0, -1.0, 0.0],
    ]))
}

/// Eye to clip space: the perspective that sees `left..right` and `bottom..top` on the plane at
/// distance `near`; off centre if these are not symmetric.
///
/// # Errors
/// [`Error::Camera`] if a side has no length or the planes are not `0 < near < far`.
pub fn frustum(
    left: f64,
    right: f64,
    bottom: f64,
    top: f64,
    planes: DepthPlanes,
) -> Result<DMat4, Error> {
    let (w, h) = sides(left, right, bottom, top)?;
    let (a, b) = planes.perspective_row()?;
    let n = planes.near;
    Ok(rows([
        [2.0 * n / w, 0.0, (right + left) / w, 0.0],
        [0.0, 2.0 * n / h, (top + bottom) / h, 0.0],
        [0.0, 0.0, -a, b],
        [0.0, 0.0, -1.0, 0.0],
    ]))
}

/// Eye to clip space without perspective (w = 1): sees `left..right`, `bottom..top`.
///
/// # Errors
/// [`Error::Camera`] if a side has no length or the planes are not `near < far`, both finite.
pub fn orthographic(
    left: f64,
    right: f64,
    bottom: f64,
    top: f64,
    planes: DepthPlanes,
) -> Result<DMat4, Error> {
    let (w, h) = sides(left, right, bottom, top)?;
    let (a, b) = planes.orthographic_row()?;
    Ok(rows([
        [2.0 / w, 0.0, 0.0, -((right + left) / w)],
        [0.0, 2.0 / h, 0.0, -((top + bottom) / h)],
        [0.0, 0.0, -a, b],
        [0.0, 0.0, 0.0, 1.0],
    ]))
}

/// Eye to clip space from a pinhole camera's intrinsics as OpenCV gives them: focal lengths and
/// principal point in pixels, where whole numbers are pixel *centres* (so the framebuffer's
/// x is OpenCV's plus 1/2). A point at eye (X, Y, -Z) lands on OpenCV pixel
/// (`fx` X/Z + `cx`, `cy` - `fy` Y/Z) of a picture of `width` x `height`.
///
/// # Errors
/// [`Error::Camera`] if a focal length or a side is not positive, or not `0 < near < far`.
pub fn intrinsics(
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
    width: u32,
    height: u32,
    planes: DepthPlanes,
) -> Result<DMat4, Error> {
    let valid = fx > 0.0 && fy > 0.0 && (fx + fy + cx + cy).is_finite() && width > 0 && height > 0;
    if !valid {
        return Err(Error::Camera("focal lengths and sides must be positive, all finite"));
    }
    let (w, h) = (f64::from(width), f64::from(height));
    let (a, b) = planes.perspective_row()?;
    Ok(rows([
        [2.0 * fx / w, 0.0, 1.0 - (2.0 * cx + 1.0) / w, 0.0],
        [0.0, 2.0 * fy / h, (2.0 * cy + 1.0) / h - 1.0, 0.0],
        [0.0, 0.0, -a, b],
        [0.0, 0.0, -1.0, 0.0],
    ]))
}

/// `a * b`, with one fixed order of operations.
pub fn multiply(a: DMat4, b: DMat4) -> DMat4 {
    DMat4::from_cols(
        transform_vector(a, b.x_axis),
        transform_vector(a, b.y_axis),
        transform_vector(a, b.z_axis),
        transform_vector(a, b.w_axis),
    )
}

/// The clip position of `point`, with one fixed order of operations.
pub fn transform(matrix: DMat4, point: DVec3) -> [f64; 4] {
    transform_vector(matrix, DVec4::new(point.x, point.y, point.z, 1.0)).to_array()
}

fn transform_vector(m: DMat4, v: DVec4) -> DVec4 {
    let row = |x: f64, y: f64, z: f64, w: f64| x * v.x + y * v.y + z * v.z + w * v.w;
    DVec4::new(
        row(m.x_axis.x, m.y_axis.x, m.z_axis.x, m.w_axis.x),
        row(m.x_axis.y, m.y_axis.y, m.z_axis.y, m.w_axis.y),
        row(m.x_axis.z, m.y_axis.z, m.z_axis.z, m.w_axis.z),
        row(m.x_axis.w, m.y_axis.w, m.z_axis.w, m.w_axis.w),
    )
}

fn sides(left: f64, right: f64, bottom: f64, top: f64) -> Result<(f64, f64), Error> {
    let (w, h) = (right - left, top - bottom);
    let valid = w != 0.0 && h != 0.0 && w.is_finite() && h.is_finite();
    if valid {
        Ok((w, h))
    } else {
        Err(Error::Camera("left and right, bottom and top must differ"))
    }
}

fn rows(r: [[f64; 4]; 4]) -> DMat4 {
    DMat4::from_cols_array_2d(&r).transpose()
}

fn sub(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(a.x - b.x, a.y - b.y, a.z - b.z)
}

fn dot(a: DVec3, b: DVec3) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

fn cross(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

/// `v` at length 1, or nothing for a length of 0 or one that is not finite.
fn unit(v: DVec3) -> Option<DVec3> {
    let length = libm::sqrt(dot(v, v));
    let fine = length > 0.0 && length < f64::INFINITY;
    fine.then(|| DVec3::new(v.x / length, v.y / length, v.z / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLANES: DepthPlanes = DepthPlanes {
        near: 0.5,
        far: 8.0,
        convention: DepthConvention::Reversed,
        range: DepthRange::ZeroToOne,
    };

    fn depth(m: DMat4, distance: f64) -> f64 {
        let p = transform(m, DVec3::new(0.0, 0.0, -distance));
        p[2] / p[3]
    }

    #[test]
    fn camera_depth_ends_are_where_they_are_said_to_be() {
        for (convention, range, near, far) in [
            (DepthConvention::Reversed, DepthRange::ZeroToOne, 1.0, 0.0),
            (DepthConvention::Standard, DepthRange::ZeroToOne, 0.0, 1.0),
            (DepthConvention::Reversed, DepthRange::MinusOneToOne, 1.0, -1.0),
            (DepthConvention::Standard, DepthRange::MinusOneToOne, -1.0, 1.0),
        ] {
            let planes = DepthPlanes { convention, range, ..PLANES };
            for m in [
                perspective(60.0, 1.5, planes).unwrap(),
                frustum(-1.0, 2.0, -1.0, 1.5, planes).unwrap(),
                orthographic(-1.0, 2.0, -1.0, 1.5, planes).unwrap(),
                intrinsics(500.0, 400.0, 319.5, 239.5, 640, 480, planes).unwrap(),
            ] {
                assert!((depth(m, 0.5) - near).abs() < 1e-12);
                assert!((depth(m, 8.0) - far).abs() < 1e-12);
            }
            let infinite = DepthPlanes { far: f64::INFINITY, ..planes };
            let m = perspective(60.0, 1.5, infinite).unwrap();
            assert!((depth(m, 0.5) - near).abs() < 1e-12);
            assert!((depth(m, 1e15) - far).abs() < 1e-12);
        }
    }

    #[test]
    fn camera_intrinsics_put_points_where_opencv_does() {
        let (fx, fy, cx, cy, w, h) = (500.0, 400.0, 310.0, 250.25, 640, 480);
        let m = intrinsics(fx, fy, cx, cy, w, h, PLANES).unwrap();
        let (x, y, z) = (0.3, -0.2, 2.0);
        let p = transform(m, DVec3::new(x, y, -z));
        let framebuffer =
            [(p[0] / p[3] + 1.0) / 2.0 * f64::from(w), (1.0 - p[1] / p[3]) / 2.0 * f64::from(h)];
        assert!((framebuffer[0] - 0.5 - (fx * x / z + cx)).abs() < 1e-10);
        assert!((framebuffer[1] - 0.5 - (cy - fy * y / z)).abs() < 1e-10);
    }

    #[test]
    fn camera_look_at_centres_its_target() {
        let (eye, target) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(-4.0, 0.5, 2.0));
        let view = look_at(eye, target, DVec3::Y).unwrap();
        let p = transform(view, target);
        assert!(p[0].abs() < 1e-12 && p[1].abs() < 1e-12 && p[2] < 0.0);
        assert!(look_at(eye, eye, DVec3::Y).is_err());
        assert!(look_at(eye, eye + DVec3::Y, DVec3::Y).is_err());
        assert!(perspective(180.0, 1.0, PLANES).is_err());
        assert!(perspective(60.0, 1.0, DepthPlanes { near: 0.0, ..PLANES }).is_err());
    }
}
