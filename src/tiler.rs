//! The driver: takes a polygon through the pipeline, stage by stage.

use alloc::vec::Vec;

use fearless_simd::{SimdBase, SimdMask, dispatch};

use crate::clip::{ClipPlane, Clipped, Clipper, VertexArrays};
use crate::depth::{Compare, DepthSource, DepthTest};
use crate::divide::{ScreenVertex, divide, snapped_area};
use crate::edge::{Outline, Span};
use crate::fixed::{Subpixel, exponent_of, power_of_two};
use crate::gradient::{ConstantAlong, Gradients, Quantity, Subject, Wanted};
use crate::lanes::{Narrow, low_bits};
use crate::polygon::Polygon;
use crate::shade::{BLOCK, Block, Inputs, Shader};
use crate::simd::Simd;
use crate::space::{PixelRect, Viewport};
use crate::span::SpanWalker;
use crate::stats::Stats;
use crate::target::{DepthBuffer, Target};
use crate::varying::Interpolation;

/// Which polygons are left out for the way they face. Front faces are counter-clockwise with
/// y up; a snapped area of 0 faces back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Cull {
    /// All are drawn.
    #[default]
    None,
    /// Back faces are left out.
    Back,
    /// Front faces are left out.
    Front,
}

/// How good attributes are; see docs/precision.md.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Precision {
    /// Within 4u |value| + 3u M of the right value. Until it has a path of its own, this is
    /// [`Exact`](Self::Exact).
    #[default]
    Fast,
    /// Correctly rounded: at most half an ulp off.
    Exact,
}

/// What became of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// It went to the spans (and may still cover no pixel centre).
    Drawn,
    /// Nothing of it lies in the view volume.
    Outside,
    /// It faces the way that is left out.
    Backface,
    /// Fewer than three vertices, or no area once snapped.
    Degenerate,
    /// A position is not finite.
    Refused,
}

/// Draws polygons: holds the viewport, the settings, the counts and the buffers that are reused
/// from one polygon to the next.
#[derive(Debug)]
pub struct Tiler {
    viewport: Viewport,
    origin: [i32; 2],
    depth_test: DepthTest,
    cull: Cull,
    precision: Precision,
    interpolation: Vec<Interpolation>,
    clipper: Clipper,
    simd: Simd,
    stats: Stats,
    scratch: Scratch,
}

/// What a polygon is turned into on its way, stage by stage; kept to save allocations.
#[derive(Debug, Default)]
struct Scratch {
    /// As given, times a power of two.
    given: Vec<[f64; 4]>,
    clipped: VertexArrays,
    screen: Vec<ScreenVertex>,
    outline: Outline,
    /// Within what is visible.
    spans: Vec<Span>,
    gradients: Gradients,
    attributes: Vec<[f32; BLOCK]>,
}

impl Tiler {
    /// A tiler for `viewport`: no culling, standard depth, every attribute with perspective.
    pub fn new(viewport: Viewport) -> Self {
        Self {
            viewport,
            origin: [0, 0],
            depth_test: DepthTest::STANDARD,
            cull: Cull::None,
            precision: Precision::Fast,
            interpolation: Vec::new(),
            clipper: Clipper::new(viewport),
            simd: Simd::auto(),
            stats: Stats::default(),
            scratch: Scratch::default(),
        }
    }

    /// The framebuffer position of the target's first pixel: (0, 0) unless set. A target that
    /// is a crop of the picture has the bytes of that part of the whole.
    pub fn set_origin(&mut self, x: i32, y: i32) -> &mut Self {
        self.origin = [x, y];
        self
    }

    /// The depth test of the calls of [`draw`](Self::draw) that have a depth buffer.
    pub fn set_depth_test(&mut self, test: DepthTest) -> &mut Self {
        self.depth_test = test;
        self
    }

    /// Which faces are left out.
    pub fn set_cull(&mut self, cull: Cull) -> &mut Self {
        self.cull = cull;
        self
    }

    /// How good attributes are.
    pub fn set_precision(&mut self, precision: Precision) -> &mut Self {
        self.precision = precision;
        self
    }

    /// How attribute 0, 1, ... is interpolated; those beyond the list have perspective.
    pub fn set_interpolation(&mut self, interpolation: &[Interpolation]) -> &mut Self {
        self.interpolation.clear();
        self.interpolation.extend_from_slice(interpolation);
        self
    }

    /// Planes to clip against beside the view volume's: any number. With planes +d and -d the
    /// two parts of a polygon cover each of its pixels exactly once.
    pub fn set_clip_planes(&mut self, planes: &[ClipPlane]) -> &mut Self {
        self.clipper.set_user_planes(planes);
        self
    }

    /// Which of the machine's instruction sets to use; the widest unless set. No bit depends on
    /// it.
    pub fn set_simd(&mut self, simd: Simd) -> &mut Self {
        self.simd = simd;
        self
    }

    /// Counts since the tiler was made or since [`reset_stats`](Self::reset_stats).
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// Sets the counts to 0.
    pub fn reset_stats(&mut self) {
        self.stats = Stats::default();
    }

    /// Draws `polygon` into `target`, through the depth test if there is a buffer for it.
    ///
    /// What lies outside the viewport, the target or the depth buffer (whose first pixel is
    /// the target's) is not drawn. Any bit pattern may come in.
    pub fn draw<V, S, T>(
        &mut self,
        polygon: &V,
        shader: &mut S,
        target: &mut T,
        depth: Option<&mut DepthBuffer<'_>>,
    ) -> Outcome
    where
        V: Polygon + ?Sized,
        S: Shader,
        T: Target<Pixel = S::Pixel>,
    {
        self.stats.polygons += 1;
        let outcome =
            dispatch!(self.simd.0, simd => self.take_through(simd, polygon, shader, target, depth));
        let culled = &mut self.stats.culled;
        match outcome {
            Outcome::Drawn => {}
            Outcome::Outside => culled.outside += 1,
            Outcome::Backface => culled.backface += 1,
            Outcome::Degenerate => culled.degenerate += 1,
            Outcome::Refused => culled.refused += 1,
        }
        self.stats.peak_bytes = self.stats.peak_bytes.max(self.bytes() as u64);
        outcome
    }

    /// The pipeline.
    #[inline(always)]
    fn take_through<L, V, S, T>(
        &mut self,
        simd: L,
        polygon: &V,
        shader: &mut S,
        target: &mut T,
        mut depth: Option<&mut DepthBuffer<'_>>,
    ) -> Outcome
    where
        L: fearless_simd::Simd,
        V: Polygon + ?Sized,
        S: Shader,
        T: Target<Pixel = S::Pixel>,
    {
        let Scratch { given, clipped, screen, outline, spans, gradients, attributes } =
            &mut self.scratch;

        // 1. The polygon, at a size where nothing overflows.
        let exponent = match take_in(polygon, given) {
            Ok(exponent) => exponent,
            Err(outcome) => return outcome,
        };

        // 2. Clip, against the crossed planes only.
        let outcodes = self.clipper.classify(given.iter().copied());
        if outcodes.hidden {
            return Outcome::Outside;
        }
        let visible: &[[f64; 4]] = if outcodes.accepted() {
            given
        } else {
            clipped.reset(0);
            given.iter().for_each(|p| clipped.push(*p, []));
            if self.clipper.clip(clipped) == Clipped::Outside || clipped.is_empty() {
                return Outcome::Outside;
            }
            self.stats.clipped += 1;
            clipped.bare_positions()
        };

        // 3. Divide by w, through the viewport, onto the subpixel grid.
        divide(visible.iter().copied(), self.viewport, screen);

        // 4. Which way it faces, exactly; and whether a pixel's centre is near.
        let area = snapped_area(screen);
        let bounds = Bounds::of(screen, self.viewport);
        let seen = bounds.rect.intersect(self.viewport.rect());
        if area == 0 && (bounds.rect.is_empty() || !outline.set(screen).covers_anything()) {
            return Outcome::Degenerate;
        }
        let left_out = match self.cull {
            Cull::None => false,
            Cull::Back => area <= 0,
            Cull::Front => area > 0,
        };
        if left_out {
            return Outcome::Backface;
        }
        let window = window(self.viewport, self.origin, target.size(), depth.as_deref());
        if seen.intersect(window).is_empty() {
            return Outcome::Drawn;
        }

        // 5. Edges: the Y loop, within what can be seen.
        let corner = self.viewport.rect();
        let [x0, x1] = [window.x0, window.x1].map(|x| x - corner.x0);
        let rows = window.y0 - corner.y0..window.y1 - corner.y0;
        spans.clear();
        let mut covered = 0_u64;
        outline.set(screen).for_each_span(rows, |span| {
            let (start, end) = (span.start.max(x0), span.end.min(x1));
            if start < end {
                covered += u64::from(end.abs_diff(start));
                spans.push(Span { start, end, ..span });
            }
        });
        if spans.is_empty() {
            return Outcome::Drawn;
        }

        // 6. Gradients, of what is asked for; found out: what is constant.
        let test = depth.is_some().then_some(self.depth_test);
        let source = test.map(|test| test.source);
        let subject = Subject {
            polygon,
            viewport: self.viewport,
            positions: given,
            exponent,
            interpolation: &self.interpolation,
            clipped_w: bounds.w(screen, visible),
            columns: [seen.x0, seen.x1 - 1],
            rows: [seen.y0, seen.y1 - 1],
            wanted: Wanted {
                depth: S::INPUTS.depth || source == Some(DepthSource::Z),
                inv_w: S::INPUTS.inv_w || source == Some(DepthSource::InvW),
                w: S::INPUTS.w,
                attributes: polygon.attribute_count().min(S::INPUTS.attributes),
                exact: self.precision == Precision::Exact,
            },
        };
        gradients.set(&subject);
        match gradients.constant {
            ConstantAlong::Nothing => {}
            ConstantAlong::Polygon => self.stats.constant_w.polygon += 1,
            ConstantAlong::Row => self.stats.constant_w.row += 1,
            ConstantAlong::Column => self.stats.constant_w.column += 1,
        }

        // 7. Spans: the X loop; depth, then attributes, then the shader, block by block.
        let mut walker = SpanWalker::new(simd, &subject, gradients, &mut self.clipper);
        let mut lanes =
            Lanes { depth: [0.0; BLOCK], inv_w: [0.0; BLOCK], w: [0.0; BLOCK], attributes };
        self.stats.spans += spans.len() as u64;
        self.stats.pixels_covered += covered;
        let mut shaded = 0_u64;
        for span in spans.iter() {
            let y = span.row + corner.y0;
            let (start, end) = (span.start + corner.x0, span.end + corner.x0);
            let target_y = y.abs_diff(self.origin[1]);
            let mut x = start & !(BLOCK_COLUMNS - 1);
            while x < end {
                let mut mask = lanes_between(start - x, end - x);
                walker.seek(x, y);
                let run = TargetRun { x, y: target_y, origin_x: self.origin[0] };
                if let (Some(test), Some(buffer)) = (test, depth.as_deref_mut()) {
                    let tested = lanes.tested(&mut walker, test.source, span, mask);
                    mask &= run.passing(simd, buffer, mask, tested, test);
                }
                if mask != 0 {
                    shaded += u64::from(mask.count_ones());
                    walker.prepare_attributes(lanes.attributes);
                    lanes.find(&mut walker, S::INPUTS, source, span, mask);
                    let block = lanes.block(x, y, mask);
                    let mut pixels = [S::Pixel::default(); BLOCK];
                    let kept = shader.shade(&block, &mut pixels) & mask;
                    run.write(target, kept, &pixels);
                    if let (Some(test), Some(buffer)) = (test, depth.as_deref_mut())
                        && test.write
                    {
                        let stored = match test.source {
                            DepthSource::Z => &lanes.depth,
                            DepthSource::InvW => &lanes.inv_w,
                        };
                        run.write(buffer, kept, stored);
                    }
                }
                x += BLOCK_COLUMNS;
            }
        }
        self.stats.exact_values += walker.exact_values;
        self.stats.pixels_shaded += shaded;
        self.stats.pixels_hidden += covered - shaded;
        Outcome::Drawn
    }

    /// Bytes that the buffers hold.
    fn bytes(&self) -> usize {
        let scratch = &self.scratch;
        scratch.given.capacity() * size_of::<[f64; 4]>()
            + scratch.clipped.bytes()
            + scratch.screen.capacity() * size_of::<ScreenVertex>()
            + scratch.outline.bytes()
            + scratch.spans.capacity() * size_of::<Span>()
            + scratch.gradients.bytes()
            + scratch.attributes.capacity() * size_of::<[f32; BLOCK]>()
            + self.clipper.bytes()
    }
}

/// Columns of a block.
const BLOCK_COLUMNS: i32 = BLOCK as i32;

/// Copies the positions, times the power of two that brings the largest number into 1..2, and
/// returns its negated exponent: so that no product overflows, no subnormal is left, and scaled
/// polygons give the same bits.
#[inline(always)]
fn take_in<V: Polygon + ?Sized>(polygon: &V, given: &mut Vec<[f64; 4]>) -> Result<i32, Outcome> {
    let n = polygon.len();
    if n < 3 {
        return Err(Outcome::Degenerate);
    }
    given.clear();
    let mut largest = 0.0_f64;
    let mut finite = true;
    given.extend((0..n).map(|i| {
        let position = polygon.position(i);
        for component in position {
            let size = component.abs();
            finite &= size < f64::INFINITY;
            largest = if size > largest { size } else { largest };
        }
        position
    }));
    if !finite {
        return Err(Outcome::Refused);
    }
    let Some(exponent) = exponent_of(largest) else { return Err(Outcome::Degenerate) };
    if exponent != 0 {
        // In two steps: the power alone may lie outside the range.
        let half = exponent / 2;
        let (first, second) = (power_of_two(-half), power_of_two(half - exponent));
        for component in given.as_flattened_mut() {
            *component = *component * first * second;
        }
    }
    Ok(exponent)
}

/// What the snapped vertices enclose.
struct Bounds {
    /// The pixels of the framebuffer whose centres may be covered.
    rect: PixelRect,
}

impl Bounds {
    #[inline(always)]
    fn of(screen: &[ScreenVertex], viewport: Viewport) -> Self {
        let Some(first) = screen.first() else { return Self { rect: PixelRect::default() } };
        let (mut low, mut high) = (first.snapped, first.snapped);
        for vertex in &screen[1..] {
            low = [0, 1].map(|k| low[k].min(vertex.snapped[k]));
            high = [0, 1].map(|k| high[k].max(vertex.snapped[k]));
        }
        let corner = viewport.rect();
        let [x0, y0] = low.map(Subpixel::first_centre);
        let [x1, y1] = high.map(Subpixel::first_centre);
        let [x0, x1] = [x0, x1].map(|x| x.saturating_add(corner.x0));
        let [y0, y1] = [y0, y1].map(|y| y.saturating_add(corner.y0));
        Self { rect: PixelRect { x0, y0, x1, y1 } }
    }

    /// Least and greatest w of the vertices that the division kept.
    #[inline(always)]
    fn w(&self, screen: &[ScreenVertex], positions: &[[f64; 4]]) -> [f64; 2] {
        screen.iter().fold([f64::INFINITY, 0.0], |[low, high], vertex| {
            let w = positions[vertex.vertex as usize][3];
            [if w < low { w } else { low }, if w > high { w } else { high }]
        })
    }
}

/// The pixels of the framebuffer that can be drawn.
#[inline(always)]
fn window(
    viewport: Viewport,
    origin: [i32; 2],
    target: (u32, u32),
    depth: Option<&DepthBuffer<'_>>,
) -> PixelRect {
    let (width, height) = match depth.map(|buffer| buffer.dimensions()) {
        Some((width, height)) => (target.0.min(width), target.1.min(height)),
        None => target,
    };
    viewport.rect().intersect(PixelRect::new(origin[0], origin[1], width, height))
}

/// The lanes `start..end` of a block; what lies beyond the block is cut.
#[inline(always)]
fn lanes_between(start: i32, end: i32) -> u16 {
    let from = u16::MAX << start.clamp(0, BLOCK_COLUMNS - 1);
    if end >= BLOCK_COLUMNS { from } else { from & !(u16::MAX << end.max(0)) }
}

/// A block's values.
struct Lanes<'a> {
    depth: [f32; BLOCK],
    inv_w: [f32; BLOCK],
    w: [f32; BLOCK],
    attributes: &'a mut Vec<[f32; BLOCK]>,
}

impl Lanes<'_> {
    /// What the depth test compares.
    #[inline(always)]
    fn tested<L: fearless_simd::Simd, V: Polygon + ?Sized>(
        &mut self,
        walker: &mut SpanWalker<'_, L, V>,
        source: DepthSource,
        span: &Span,
        mask: u16,
    ) -> &[f32; BLOCK] {
        let (quantity, lanes) = match source {
            DepthSource::Z => (Quantity::Depth, &mut self.depth),
            DepthSource::InvW => (Quantity::InvW, &mut self.inv_w),
        };
        walker.evaluate(quantity, span, mask, lanes);
        lanes
    }

    /// Everything that the shader reads and the depth test has not found.
    #[inline(always)]
    fn find<L: fearless_simd::Simd, V: Polygon + ?Sized>(
        &mut self,
        walker: &mut SpanWalker<'_, L, V>,
        inputs: Inputs,
        tested: Option<DepthSource>,
        span: &Span,
        mask: u16,
    ) {
        if inputs.depth && tested != Some(DepthSource::Z) {
            walker.evaluate(Quantity::Depth, span, mask, &mut self.depth);
        }
        if inputs.inv_w && tested != Some(DepthSource::InvW) {
            walker.evaluate(Quantity::InvW, span, mask, &mut self.inv_w);
        }
        if inputs.w {
            walker.evaluate(Quantity::W, span, mask, &mut self.w);
        }
        for (k, lanes) in self.attributes.iter_mut().enumerate() {
            if !walker.is_constant(k) {
                walker.evaluate(Quantity::Attribute(k), span, mask, lanes);
            }
        }
    }

    #[inline(always)]
    fn block(&self, x: i32, y: i32, mask: u16) -> Block<'_> {
        Block {
            x,
            y,
            mask,
            depth: &self.depth,
            inv_w: &self.inv_w,
            w: &self.w,
            attributes: self.attributes,
        }
    }
}

/// The lanes at which `new` passes against `stored`.
#[inline(always)]
fn passing_lanes<L: fearless_simd::Simd>(
    compare: Compare,
    new: Narrow<L>,
    stored: Narrow<L>,
) -> u16 {
    let lanes = match compare {
        Compare::Never => return 0,
        Compare::Less => new.simd_lt(stored),
        Compare::Equal => new.simd_eq(stored),
        Compare::LessEqual => new.simd_le(stored),
        Compare::Greater => new.simd_gt(stored),
        Compare::NotEqual => return !low_bits(new.simd_eq(stored).to_bitmask()),
        Compare::GreaterEqual => new.simd_ge(stored),
        Compare::Always => return u16::MAX,
    };
    low_bits(lanes.to_bitmask())
}

/// Where a block lies in the target: its row there, and its first column in the framebuffer.
#[derive(Clone, Copy)]
struct TargetRun {
    x: i32,
    y: u32,
    origin_x: i32,
}

impl TargetRun {
    /// The lanes of `mask` whose depth passes.
    #[inline(always)]
    fn passing<L: fearless_simd::Simd>(
        self,
        simd: L,
        buffer: &DepthBuffer<'_>,
        mask: u16,
        depth: &[f32; BLOCK],
        test: DepthTest,
    ) -> u16 {
        let row = buffer.row(self.y);
        let whole = usize::try_from(self.x - self.origin_x).ok();
        let stored = whole.and_then(|start| row.get(start..)?.first_chunk::<BLOCK>());
        let mut part = [0.0; BLOCK];
        let stored = stored.unwrap_or_else(|| {
            let first = mask.trailing_zeros() as usize;
            let last = BLOCK - mask.leading_zeros() as usize;
            let start = self.column(first);
            part[first..last].copy_from_slice(&row[start..start + last - first]);
            &part
        });
        let new = Narrow::load_array_ref(simd, depth);
        mask & passing_lanes(test.compare, new, Narrow::load_array_ref(simd, stored))
    }

    /// The target's column of lane `lane`, which lies in it.
    #[inline(always)]
    fn column(self, lane: usize) -> usize {
        (self.x - self.origin_x)
            .wrapping_add_unsigned(u32::try_from(lane).unwrap_or(0))
            .unsigned_abs() as usize
    }

    /// Hands the lanes of `mask` to the target, run by run.
    #[inline(always)]
    fn write<T: Target>(self, target: &mut T, mask: u16, pixels: &[T::Pixel; BLOCK]) {
        let mut left = mask;
        while left != 0 {
            let first = left.trailing_zeros();
            let count = (left >> first).trailing_ones();
            let run = &pixels[first as usize..(first + count) as usize];
            let column = self.column(first as usize);
            target.write(u32::try_from(column).unwrap_or(u32::MAX), self.y, run);
            // In two shifts: the run may be all 16.
            left &= (u16::MAX << (first + count - 1)) << 1;
        }
    }
}
