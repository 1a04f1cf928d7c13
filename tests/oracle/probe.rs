//! Draws with the library and records what arrives.

use std::collections::BTreeMap;

use hyperspan::polygon::Polygon;
use hyperspan::shade::{BLOCK, Block, Fragment, Inputs, Shader};
use hyperspan::space::{PixelRect, Viewport};
use hyperspan::stats::Stats;
use hyperspan::target::{Plane, Target};
use hyperspan::tiler::{Outcome, Precision, Tiler};
use hyperspan::varying::Interpolation;

use super::Poly;

/// A shader that sees everything. Every closure is a type of its own, for which much is compiled: this is one.
pub(crate) type Closure<'a, P> = &'a mut dyn FnMut(&Fragment<'_>) -> P;

/// A target that keeps what it is given, and panics if a pixel is written twice or lies outside.
#[derive(Debug)]
pub(crate) struct Sheet<P> {
    width: u32,
    height: u32,
    /// Row by row.
    pub(crate) pixels: Vec<Option<P>>,
}

impl<P: Copy> Sheet<P> {
    pub(crate) fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![None; width as usize * height as usize] }
    }
}

impl<P: Copy + Default + 'static> Target for Sheet<P> {
    type Pixel = P;

    fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    fn write(&mut self, x: u32, y: u32, run: &[P]) {
        assert!((1..=16).contains(&run.len()), "a run of {} pixels", run.len());
        for (x, pixel) in (x..).zip(run) {
            assert!(x < self.width && y < self.height, "({x}, {y}) lies outside the target");
            let place = &mut self.pixels[y as usize * self.width as usize + x as usize];
            assert!(place.replace(*pixel).is_none(), "({x}, {y}) is drawn twice");
        }
    }
}

/// Everything that a shader sees of a pixel, as bits.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Seen {
    pub(crate) depth: u32,
    pub(crate) inv_w: u32,
    pub(crate) w: u32,
    pub(crate) attributes: Vec<u32>,
}

/// Pixels by (row, column) in the framebuffer.
pub(crate) type Picture = BTreeMap<(i32, i32), Seen>;

/// What to draw through.
#[derive(Clone, Debug)]
pub(crate) struct View {
    pub(crate) viewport: Viewport,
    /// The pixels of the target.
    pub(crate) window: PixelRect,
    pub(crate) interpolation: Vec<Interpolation>,
    pub(crate) precision: Precision,
}

impl View {
    /// A target of the viewport's size and place.
    pub(crate) fn whole(viewport: Viewport) -> Self {
        Self {
            viewport,
            window: viewport.rect(),
            interpolation: Vec::new(),
            precision: Precision::Exact,
        }
    }

    /// The pixels that may be drawn.
    pub(crate) fn visible(&self) -> PixelRect {
        self.viewport.rect().intersect(self.window)
    }

    /// A tiler for it.
    pub(crate) fn tiler(&self) -> Tiler {
        let mut tiler = Tiler::new(self.viewport);
        tiler
            .set_origin(self.window.x0, self.window.y0)
            .set_precision(self.precision)
            .set_interpolation(&self.interpolation);
        tiler
    }

    /// (width, height) of the target.
    pub(crate) fn size(&self) -> (u32, u32) {
        let side = |from: i32, to: i32| u32::try_from(to - from).expect("a window");
        (side(self.window.x0, self.window.x1), side(self.window.y0, self.window.y1))
    }
}

/// Draws `polygon` alone.
pub(crate) fn draw<V: Polygon + ?Sized>(view: &View, polygon: &V) -> (Outcome, Picture, Stats) {
    let mut tiler = view.tiler();
    let (outcome, picture) = draw_with(&mut tiler, view, polygon);
    let stats = tiler.stats();
    let pixels = picture.len() as u64;
    let counted = (stats.pixels_covered, stats.pixels_shaded, stats.pixels_hidden);
    assert_eq!(counted, (pixels, pixels, 0));
    (outcome, picture, stats)
}

/// Draws `polygon` with a tiler that has the view's settings.
pub(crate) fn draw_with<V: Polygon + ?Sized>(
    tiler: &mut Tiler,
    view: &View,
    polygon: &V,
) -> (Outcome, Picture) {
    let (width, height) = view.size();
    let mut sheet = Sheet::<u32>::new(width, height);
    let mut seen = Vec::new();
    // Shades the pixels with their numbers, from 1 on.
    let mut recorder: Closure<'_, u32> = &mut |f| {
        let attributes = (0..f.attribute_count()).map(|k| f.attribute(k).to_bits()).collect();
        let (depth, inv_w, w) = (f.depth().to_bits(), f.inv_w().to_bits(), f.w().to_bits());
        seen.push(((f.y(), f.x()), Seen { depth, inv_w, w, attributes }));
        u32::try_from(seen.len()).expect("few pixels")
    };
    let outcome = tiler.draw(polygon, &mut recorder, &mut sheet, None);
    // Each was written where it was shaded, and all that were shaded were written.
    for (place, number) in sheet.pixels.iter().enumerate().filter_map(|(i, p)| Some((i, (*p)?))) {
        let (row, column) = (place / width as usize, place % width as usize);
        let (y, x) = seen[number as usize - 1].0;
        let at = (y - view.window.y0, x - view.window.x0);
        assert_eq!(at, (row as i32, column as i32), "shaded there, written here");
    }
    assert_eq!(sheet.pixels.iter().flatten().count(), seen.len(), "shaded, but not written");
    (outcome, seen.into_iter().collect())
}

/// Which pixels `polygon` covers.
pub(crate) fn coverage(view: &View, polygon: &Poly) -> Vec<(i32, i32)> {
    draw(view, polygon).1.keys().map(|&(y, x)| (x, y)).collect()
}

/// Attribute `k`, in the rows of a plane: the way of those who draw fast.
#[derive(Clone)]
pub(crate) struct One(pub(crate) usize);

impl Shader for One {
    type Pixel = u32;
    const INPUTS: Inputs = Inputs::attributes(usize::MAX);
    const KEEPS_ALL: bool = true;

    fn shade(&mut self, block: &Block<'_>, out: &mut [u32; BLOCK]) -> u16 {
        if let Some(lanes) = block.attributes.get(self.0) {
            *out = lanes.map(f32::to_bits);
        }
        block.mask
    }
}

/// Does `polygon` have the pixels and the values of `picture` also where whole blocks are shaded in a
/// plane's rows, through a depth test that all pass?
pub(crate) fn same_in_rows<V: Polygon + ?Sized>(
    view: &View,
    polygon: &V,
    picture: &Picture,
) -> Result<(), String> {
    const NOTHING: u32 = 0xDEAD_BEEF;
    let (width, height) = view.size();
    let area = width as usize * height as usize;
    for k in 0..polygon.attribute_count() {
        let (mut values, mut depths) = (vec![NOTHING; area], vec![2.0; area]);
        let mut target = Plane::new(&mut values, width, height).expect("its size");
        let mut depth = Plane::new(&mut depths, width, height).expect("its size");
        view.tiler().draw(polygon, &mut One(k), &mut target, Some(&mut depth));
        for (i, (value, depth)) in values.iter().zip(&depths).enumerate() {
            let (row, column) = (i / width as usize, i % width as usize);
            let at = (row as i32 + view.window.y0, column as i32 + view.window.x0);
            let wanted = picture.get(&at).map(|seen| (seen.attributes[k], seen.depth));
            let found = (*value, depth.to_bits());
            if found != wanted.unwrap_or((NOTHING, 2.0_f32.to_bits())) {
                return Err(format!(
                    "attribute {k} in rows at {at:?}: {found:x?}, not {wanted:x?}"
                ));
            }
        }
    }
    Ok(())
}
