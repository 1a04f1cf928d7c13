//! Other rasterizers, on our scenes, as their documentation shows them. None of them takes
//! polygons: they get fans of triangles.

pub(crate) mod euc;
pub(crate) mod retrofire;

use crate::scenes::{Corner, Face, Look, Scene};

/// A face as a fan.
pub(crate) fn fan(scene: &Scene, face: Face) -> impl Iterator<Item = [u32; 3]> {
    let indices = &scene.indices[face.start..face.end];
    (1..indices.len() - 1).map(|i| [indices[0], indices[i], indices[i + 1]])
}

/// Runs of faces that look the same: they go into one draw call.
pub(crate) fn runs(scene: &Scene) -> impl Iterator<Item = (Look, &[Face])> {
    scene.faces.chunk_by(|a, b| a.look == b.look).map(|faces| (faces[0].look, faces))
}

/// In `f32`, which is what they take.
pub(crate) fn position(corner: &Corner) -> [f32; 3] {
    corner.position.map(|c| c as f32)
}

/// Rows of the matrix from world to clip space.
pub(crate) fn rows(scene: &Scene) -> [[f32; 4]; 4] {
    scene.camera.transpose().to_cols_array_2d().map(|row| row.map(|c| c as f32))
}

/// 0..1 to 0..255.
pub(crate) fn byte(channel: f32) -> u8 {
    (channel * 255.0 + 0.5) as u8
}
