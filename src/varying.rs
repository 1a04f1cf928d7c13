//! How an attribute runs over a polygon.
//!
//! An attribute ("varying" in shading languages) is an `f32` at each vertex. How it is
//! interpolated is data, chosen for each attribute, and never follows from a type.

/// How one attribute is interpolated between the vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Interpolation {
    /// Linear on the polygon itself: s/w and 1/w run linearly in the framebuffer, and the
    /// pixel's value is their quotient ("hyperbolic" in Blinn 1992, "rational linear" in
    /// Heckbert and Moreton 1991).
    #[default]
    Perspective,
    /// Linear in the framebuffer, as if every w were 1.
    NoPerspective,
    /// The value at the first vertex of the list, all over.
    Flat,
}

/// What a NaN is written as, whatever bits it came with.
pub const CANONICAL_NAN: f32 = f32::from_bits(0x7FC0_0000);
