//! One quad over the whole picture.

use hyperspan::polygon::Vertex;
use hyperspan::shade::{BLOCK, Block, Inputs, Shader};
use hyperspan::target::{DepthBuffer, Plane};
use hyperspan::tiler::Tiler;

/// Along which axes w changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slope {
    Neither,
    Down,
    Across,
    Both,
}

impl Slope {
    pub(crate) const ALL: [(&'static str, Self); 4] = [
        ("polygon", Self::Neither),
        ("row", Self::Down),
        ("column", Self::Across),
        ("nowhere", Self::Both),
    ];

    /// Has `tiler` counted nothing but what it is to find on such quads?
    pub(crate) fn is_found(self, tiler: &Tiler) -> bool {
        let stats = tiler.stats();
        let [polygon, row, column] =
            [stats.constant_w.polygon, stats.constant_w.row, stats.constant_w.column];
        let all = stats.polygons;
        [polygon, row, column]
            == match self {
                Self::Neither => [all, 0, 0],
                Self::Down => [0, all, 0],
                Self::Across => [0, 0, all],
                Self::Both => [0, 0, 0],
            }
    }
}

/// A flat quad that covers the picture; w runs from 1 to 2 (to 3 along the diagonal).
pub(crate) struct Quad<const N: usize>(pub(crate) [Vertex<N, [f64; 4]>; 4]);

impl<const N: usize> Quad<N> {
    /// Each attribute runs over so much of its range, in a direction of its own.
    pub(crate) fn new(slope: Slope, ranges: [f32; N]) -> Self {
        let (across, down) = match slope {
            Slope::Neither => (0.0, 0.0),
            Slope::Down => (0.0, 1.0),
            Slope::Across => (1.0, 0.0),
            Slope::Both => (1.0, 0.5),
        };
        // 1/w is affine in the picture, and with it all that is affine over w.
        let corner = |x: f64, y: f64| {
            let inv_w = 1.0 - 0.25 * (across * (x + 1.0) + down * (1.0 - y)) / 1.5;
            let w = 1.0 / inv_w;
            let attributes = std::array::from_fn(|k| {
                let turn = if k % 2 == 0 { x + 0.3 * y } else { 0.2 * x - y };
                0.5 + ranges[k] * (turn * w) as f32 / 3.0
            });
            Vertex::new([x * w, y * w, 0.5 * w, w], attributes)
        };
        Self([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)])
    }
}

/// The bits of `N` attributes together: reads them all, and does nothing else.
pub(crate) struct Bits<const N: usize>;

impl<const N: usize> Shader for Bits<N> {
    type Pixel = [u8; 4];
    const INPUTS: Inputs = Inputs::attributes(N);
    const KEEPS_ALL: bool = true;

    #[inline(always)]
    fn shade(&mut self, block: &Block<'_>, out: &mut [[u8; 4]; BLOCK]) -> u16 {
        // A number of attributes that is known: else the compiler does it lane by lane.
        let Some(attributes) = block.attributes.first_chunk::<N>() else { return 0 };
        for lane in 0..BLOCK {
            let mut bits = 0;
            for attribute in attributes {
                bits ^= attribute[lane].to_bits();
            }
            out[lane] = bits.to_ne_bytes();
        }
        block.mask
    }
}

/// A picture of 1920 x 1080 with its depth.
pub(crate) struct Canvas {
    colour: Vec<[u8; 4]>,
    depth: Vec<f32>,
}

impl Canvas {
    const SIZE: (u32, u32) = (1920, 1080);
    pub(crate) const PIXELS: u64 = 1920 * 1080;

    pub(crate) fn new() -> Self {
        let area = Self::PIXELS as usize;
        Self { colour: vec![[0; 4]; area], depth: vec![1.0; area] }
    }

    pub(crate) fn target(&mut self) -> Plane<'_, [u8; 4]> {
        self.target_and_depth().0
    }

    pub(crate) fn target_and_depth(&mut self) -> (Plane<'_, [u8; 4]>, DepthBuffer<'_>) {
        let (width, height) = Self::SIZE;
        let target = Plane::new(&mut self.colour, width, height).expect("its size");
        (target, Plane::new(&mut self.depth, width, height).expect("its size"))
    }
}
