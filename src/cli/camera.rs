//! From flags and `--camera` files to the one matrix that takes the model to clip space, and
//! from a model's bounds to a camera where neither says.

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use glam::{DMat4, DVec3, DVec4};
use hyperspan::camera::{self, DepthConvention, DepthPlanes};
use hyperspan::space::DepthRange;
use serde_json::{Map, Value};

use crate::failure::{Failure, Place, warn};
use crate::flags::{Intrinsics, Size, Triple};

/// Where the camera is and what it sees. What is left out is chosen so that the whole model is
/// seen from the upper right.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Camera")]
pub(crate) struct CameraFlags {
    /// eye, target, up, `fov_y_degrees`, near, far (a number or "inf"), width and height, each
    /// optional; the flags below override it.
    #[arg(long, value_name = "FILE.json")]
    camera: Option<PathBuf>,

    /// Size of the picture in pixels [default: 1280x720]
    #[arg(long, value_name = "WxH", allow_hyphen_values = true)]
    size: Option<Size>,

    /// The eye [default: the upper right, far enough to see the whole model]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    eye: Option<Triple>,

    /// What is in the middle of the view [default: the model's middle]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    target: Option<Triple>,

    /// The direction that is up in the picture [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    up: Option<Triple>,

    /// Vertical field of view [default: 40]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, conflicts_with_all = ["ortho", "intrinsics"])]
    fov_y: Option<f64>,

    /// Distance of the near plane [default: just before the model, but 1/1000 of its radius at
    /// least]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    near: Option<f64>,

    /// Distance of the far plane, or inf [default: inf; with --ortho just behind the model]
    #[arg(long, value_name = "F", allow_hyphen_values = true)]
    far: Option<f64>,

    /// A view without perspective, HEIGHT units of the model high.
    #[arg(long, value_name = "HEIGHT", allow_hyphen_values = true, conflicts_with = "intrinsics")]
    ortho: Option<f64>,

    /// Focal lengths and principal point in pixels as OpenCV gives them (whole numbers are
    /// pixel centres), instead of a field of view.
    #[arg(long, value_name = "FX,FY,CX,CY", allow_hyphen_values = true)]
    intrinsics: Option<Intrinsics>,

    /// Where depth is 1: at the near plane (test GREATER, clear to 0) or at the far one (test
    /// LESS, clear to 1).
    #[arg(long, value_enum, default_value = "reversed")]
    depth: DepthFlag,
}

/// `--depth` of `render`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum DepthFlag {
    /// 1 at the near plane, 0 far away.
    Reversed,
    /// 0 at the near plane, 1 far away.
    Standard,
}

/// What the camera is to see.
#[derive(Clone, Debug)]
pub(crate) struct Subject<P> {
    /// The middle of it, in world space.
    pub(crate) centre: DVec3,
    /// The distance of the farthest point from there, above 0.
    pub(crate) radius: f64,
    /// All points of it, finite.
    pub(crate) points: P,
}

/// A camera, ready to draw.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    /// Size of the picture.
    pub(crate) size: Size,
    /// World to clip space.
    pub(crate) matrix: DMat4,
    /// Which end of depth is 1.
    pub(crate) depth: DepthFlag,
    /// From the model towards the eye's side, the right and the top of the view: unit vectors.
    pub(crate) axes: [DVec3; 3],
    /// The eye; nothing where all rays are parallel to the first axis.
    pub(crate) eye: Option<DVec3>,
}

/// How eye space becomes clip space.
#[derive(Clone, Copy, Debug)]
enum Lens {
    FieldOfView(f64),
    Parallel(f64),
    Pinhole([f64; 4]),
}

/// What a `--camera` file says; the flags are laid over it.
#[derive(Clone, Debug, Default)]
struct Settings {
    eye: Option<DVec3>,
    target: Option<DVec3>,
    up: Option<DVec3>,
    fov_y: Option<f64>,
    near: Option<f64>,
    far: Option<f64>,
    size: Option<Size>,
}

impl CameraFlags {
    /// What can be said before the model is read: flags and file laid over each other.
    pub(crate) fn resolve(&self) -> Result<ResolvedCamera, Failure> {
        let file = self.camera.as_deref().map_or_else(|| Ok(Settings::default()), read)?;
        let vector = |flag: Option<Triple>, file: Option<DVec3>| {
            flag.map(|Triple(numbers)| DVec3::from_array(numbers)).or(file)
        };
        let lens = match (self.ortho, self.intrinsics) {
            (Some(height), _) => Lens::Parallel(height),
            (None, Some(Intrinsics(pinhole))) => Lens::Pinhole(pinhole),
            (None, None) => Lens::FieldOfView(self.fov_y.or(file.fov_y).unwrap_or(40.0)),
        };
        let flag = |name| Failure::new(format!("--{name} must be a number above 0"));
        match lens {
            Lens::Parallel(height) if !(height > 0.0 && height.is_finite()) => {
                return Err(flag("ortho"));
            }
            Lens::FieldOfView(degrees) if !(degrees > 0.0 && degrees < 180.0) => {
                return Err(Failure::new(
                    "the vertical field of view must lie between 0 and 180 degrees",
                ));
            }
            _ => {}
        }
        Ok(ResolvedCamera {
            settings: Settings {
                eye: vector(self.eye, file.eye),
                target: vector(self.target, file.target),
                up: vector(self.up, file.up),
                fov_y: None,
                near: self.near.or(file.near),
                far: self.far.or(file.far),
                size: None,
            },
            size: self.size.or(file.size).unwrap_or(Size::DEFAULT),
            lens,
            depth: self.depth,
        })
    }
}

/// Flags and file laid over each other; what they leave open waits for the model.
#[derive(Clone, Debug)]
pub(crate) struct ResolvedCamera {
    settings: Settings,
    /// Size of the picture.
    pub(crate) size: Size,
    lens: Lens,
    depth: DepthFlag,
}

impl ResolvedCamera {
    /// The camera, with whatever is still open chosen to show `subject`.
    pub(crate) fn frame(
        &self,
        subject: &Subject<impl Iterator<Item = DVec3> + Clone>,
    ) -> Result<Camera, Failure> {
        let Settings { eye, target, up, near, far, .. } = self.settings;
        let target = target.unwrap_or(subject.centre);
        let up = up.unwrap_or(DVec3::Y);
        let eye = eye.map_or_else(|| self.eye(subject, target, up), Ok)?;
        let view = camera::look_at(eye, target, up)?;

        // Where the model is along the view axis, with some air.
        let along = subject.points.clone().map(|point| -camera::transform(view, point)[2]);
        let (nearest, farthest) = along.fold((f64::INFINITY, 0.0_f64), |(nearest, farthest), d| {
            (nearest.min(d), farthest.max(d))
        });
        let air = 0.05 * subject.radius;
        let parallel = matches!(self.lens, Lens::Parallel(_));
        let near = near.unwrap_or(match nearest {
            f64::INFINITY => 1.0,
            _ if parallel => nearest - air,
            _ => (0.95 * nearest).max(subject.radius / 1000.0),
        });
        let far = far.unwrap_or(match self.lens {
            Lens::Parallel(_) => farthest.max(near) + air,
            _ => f64::INFINITY,
        });
        let convention = match self.depth {
            DepthFlag::Reversed => DepthConvention::Reversed,
            DepthFlag::Standard => DepthConvention::Standard,
        };
        let planes = DepthPlanes { near, far, convention, range: DepthRange::ZeroToOne };
        let Size { width, height } = self.size;
        let aspect = f64::from(width) / f64::from(height);
        let projection = match self.lens {
            Lens::FieldOfView(degrees) => camera::perspective(degrees, aspect, planes)?,
            Lens::Parallel(height) => {
                let (x, y) = (height * aspect / 2.0, height / 2.0);
                camera::orthographic(-x, x, -y, y, planes)?
            }
            Lens::Pinhole([fx, fy, cx, cy]) => {
                camera::intrinsics(fx, fy, cx, cy, width, height, planes)?
            }
        };
        Ok(Camera {
            size: self.size,
            matrix: camera::multiply(projection, view),
            depth: self.depth,
            axes: axes(view),
            eye: (!parallel).then_some(eye),
        })
    }

    /// Where the eye is if nobody says: to the upper right, just so far away that all of the
    /// model is seen.
    fn eye(
        &self,
        subject: &Subject<impl Iterator<Item = DVec3> + Clone>,
        target: DVec3,
        up: DVec3,
    ) -> Result<DVec3, Failure> {
        const SEEN_FROM: DVec3 = DVec3::new(0.5, 0.35, 1.0);
        const AIR: f64 = 1.05;

        let [back, right, up] = axes(camera::look_at(target + SEEN_FROM, target, up)?);
        let (width, height) = (f64::from(self.size.width), f64::from(self.size.height));
        // Tangents of half the view; to the nearer side, where the axis is not in the middle.
        let (x, y) = match self.lens {
            Lens::Parallel(_) => return Ok(target + back * (2.0 * subject.radius)),
            Lens::FieldOfView(degrees) => {
                let y = libm::tan(degrees.to_radians() / 2.0);
                (y * width / height, y)
            }
            Lens::Pinhole([fx, fy, cx, cy]) => {
                // A view that does not hold its own axis frames nothing: far away, at least.
                const LEAST: f64 = 0.01;
                let side = |c: f64, size: f64| (c + 0.5).min(size - 0.5 - c);
                ((side(cx, width) / fx).max(LEAST), (side(cy, height) / fy).max(LEAST))
            }
        };
        let distance = |point: DVec3| {
            let d = point - target;
            let beside = (dot(d, right).abs() / x).max(dot(d, up).abs() / y);
            dot(d, back) + AIR * beside
        };
        let least = 0.05 * subject.radius;
        let far_enough = subject.points.clone().map(distance).fold(0.0, f64::max) + least;
        Ok(target + back * far_enough)
    }
}

/// The axes of eye space in world space: backwards, right, up.
fn axes(view: DMat4) -> [DVec3; 3] {
    let rows = view.transpose();
    [rows.z_axis, rows.x_axis, rows.y_axis].map(DVec4::truncate)
}

fn dot(a: DVec3, b: DVec3) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Reads a `--camera` file.
fn read(path: &Path) -> Result<Settings, Failure> {
    let bytes = fs::read(path).map_err(|e| Failure::io(path, "read", &e))?;
    let value: Value = serde_json::from_slice(&bytes).map_err(|e| {
        let line = u64::try_from(e.line()).unwrap_or(1).max(1);
        Failure::at(Place::line(path, line), format!("this is no JSON: {e}"))
    })?;
    let Value::Object(object) = value else {
        return Err(wrong(path, "a camera is a JSON object: {\"eye\": [x, y, z], ...}"));
    };
    const KEYS: [&str; 8] =
        ["eye", "target", "up", "fov_y_degrees", "near", "far", "width", "height"];
    for key in object.keys().filter(|key| !KEYS.contains(&key.as_str())) {
        let known = KEYS.join(", ");
        warn(&Place::file(path), &format!("`{key}` is not known and ignored; known are {known}"));
    }
    let size = match (side(path, &object, "width")?, side(path, &object, "height")?) {
        (Some(width), Some(height)) => {
            Some(Size::new(width, height).map_err(|message| wrong(path, &message))?)
        }
        (None, None) => None,
        _ => return Err(wrong(path, "give both `width` and `height`, or neither")),
    };
    Ok(Settings {
        eye: vector(path, &object, "eye")?,
        target: vector(path, &object, "target")?,
        up: vector(path, &object, "up")?,
        fov_y: number(path, &object, "fov_y_degrees")?,
        near: number(path, &object, "near")?,
        far: match object.get("far") {
            Some(Value::String(text)) if text == "inf" => Some(f64::INFINITY),
            Some(Value::String(_)) => {
                return Err(wrong(path, "`far` must be a number or \"inf\""));
            }
            _ => number(path, &object, "far")?,
        },
        size,
    })
}

fn wrong(path: &Path, message: &str) -> Failure {
    Failure::at(Place::file(path), message)
}

fn vector(path: &Path, object: &Map<String, Value>, key: &str) -> Result<Option<DVec3>, Failure> {
    let Some(value) = object.get(key) else { return Ok(None) };
    let numbers: Option<Vec<f64>> =
        value.as_array().and_then(|items| items.iter().map(Value::as_f64).collect());
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(Some(DVec3::new(x, y, z))),
        _ => Err(wrong(path, &format!("`{key}` must be three numbers: [x, y, z]"))),
    }
}

fn number(path: &Path, object: &Map<String, Value>, key: &str) -> Result<Option<f64>, Failure> {
    let Some(value) = object.get(key) else { return Ok(None) };
    value.as_f64().map(Some).ok_or_else(|| wrong(path, &format!("`{key}` must be a number")))
}

fn side(path: &Path, object: &Map<String, Value>, key: &str) -> Result<Option<u64>, Failure> {
    let Some(value) = object.get(key) else { return Ok(None) };
    let whole = || wrong(path, &format!("`{key}` must be a whole number of pixels"));
    value.as_u64().map(Some).ok_or_else(whole)
}
