//! A case: polygons, and the rule that they must follow.

use hyperspan::space::{DepthRange, PixelRect, Viewport};

use crate::oracle::Poly;
use crate::oracle::coverage::{covered, is_unclipped, snapped};
use crate::oracle::judge;
use crate::oracle::probe::{self, Seen, View};

/// What all polygons of a case together must cover.
#[derive(Clone, Debug)]
pub(crate) enum Rule {
    /// Each what the oracles say, no more.
    Each,
    /// Every pixel of the target, once.
    Everywhere,
    /// The pixels of this polygon, each once.
    Once(Poly),
    /// No pixel.
    Nothing,
}

/// Polygons as a `.poly` file has them: positions are those of `f32`.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) size: [u32; 2],
    /// The part that is drawn.
    pub(crate) crop: PixelRect,
    pub(crate) gl: bool,
    pub(crate) polygons: Vec<Poly>,
    pub(crate) rule: Rule,
}

/// What became of a case, for each pixel of the crop.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Drawn {
    /// How many polygons cover it.
    pub(crate) overdraw: Vec<u32>,
    /// The last of them.
    pub(crate) ids: Vec<u32>,
    /// Its depth, w and attributes, as bits.
    pub(crate) depth: Vec<u32>,
    pub(crate) w: Vec<u32>,
    pub(crate) attributes: Vec<Vec<u32>>,
}

impl Case {
    /// A case on a whole picture. Positions are rounded to `f32`.
    pub(crate) fn new(
        name: impl Into<String>,
        size: [u32; 2],
        polygons: Vec<Poly>,
        rule: Rule,
    ) -> Self {
        let rounded = |mut poly: Poly| {
            poly.positions.iter_mut().flatten().for_each(|c| *c = f64::from(*c as f32));
            poly
        };
        let rule = match rule {
            Rule::Once(outline) => Rule::Once(rounded(outline)),
            rule => rule,
        };
        Self {
            name: name.into(),
            size,
            crop: PixelRect::new(0, 0, size[0], size[1]),
            gl: false,
            polygons: polygons.into_iter().map(rounded).collect(),
            rule,
        }
    }

    pub(crate) fn view(&self) -> View {
        let range = if self.gl { DepthRange::MinusOneToOne } else { DepthRange::ZeroToOne };
        let viewport = Viewport::new(0, 0, self.size[0], self.size[1]).expect("16384 at most");
        View { window: self.crop, ..View::whole(viewport.with_depth_range(range)) }
    }

    /// Draws it with the library and judges it: each polygon against the oracles, all of them
    /// against the rule.
    pub(crate) fn draw(&self) -> Drawn {
        let view = self.view();
        let (width, height) = view.size();
        let pixels = width as usize * height as usize;
        let count = self.polygons.first().map_or(0, |poly| poly.attributes[0].len());
        let mut drawn = Drawn {
            overdraw: vec![0; pixels],
            ids: vec![u32::MAX; pixels],
            depth: vec![0; pixels],
            w: vec![0; pixels],
            attributes: vec![vec![0; count]; pixels],
        };
        for (id, poly) in (0..).zip(&self.polygons) {
            let (_, picture, _) = probe::draw(&view, poly);
            let coverage = judge::coverage(&view, poly, &picture);
            assert_eq!(coverage, Ok(()), "{}, polygon {id}: {poly:?}", self.name);
            if let Err(wrong) = judge::values(&view, poly, &picture) {
                panic!("{}, polygon {id}: {wrong}: {poly:?}", self.name);
            }
            for ((y, x), Seen { depth, w, attributes, .. }) in picture {
                let (row, column) = (y - self.crop.y0, x - self.crop.x0);
                let at = row as usize * width as usize + column as usize;
                drawn.overdraw[at] += 1;
                drawn.ids[at] = id;
                (drawn.depth[at], drawn.w[at]) = (depth, w);
                drawn.attributes[at] = attributes;
            }
        }
        self.judge(&view, &drawn);
        drawn
    }

    /// Does it show no pixel?
    pub(crate) fn is_empty(&self) -> bool {
        self.polygons.iter().all(|poly| probe::coverage(&self.view(), poly).is_empty())
    }

    fn judge(&self, view: &View, drawn: &Drawn) {
        let name = &self.name;
        let once = |right: &dyn Fn(i32, i32) -> bool| {
            let width = view.size().0 as usize;
            for (at, count) in drawn.overdraw.iter().enumerate() {
                let (x, y) = ((at % width) as i32, (at / width) as i32);
                let right = u32::from(right(x + self.crop.x0, y + self.crop.y0));
                assert_eq!(*count, right, "{name}: ({x}, {y}) is drawn {count} times");
            }
        };
        match &self.rule {
            Rule::Each => assert!(drawn.overdraw.iter().any(|count| *count > 0), "{name}: nothing"),
            Rule::Everywhere => once(&|_, _| true),
            Rule::Nothing => once(&|_, _| false),
            Rule::Once(outline) => {
                assert!(is_unclipped(view.viewport, outline), "{name}: say `Everywhere`");
                let points = snapped(view.viewport, outline);
                let inside: std::collections::BTreeSet<(i32, i32)> =
                    covered(view.viewport.grid(), &points, view.visible()).into_iter().collect();
                assert!(!inside.is_empty(), "{name}: nothing to cover");
                once(&|x, y| inside.contains(&(x, y)));
            }
        }
    }
}

/// Judges all cases, through the library, and through the program where there is one.
pub(crate) fn check(cases: &[Case]) {
    for case in cases {
        let drawn = case.draw();
        #[cfg(feature = "cli")]
        crate::tile::check(case, &drawn);
        #[cfg(not(feature = "cli"))]
        let _ = drawn;
    }
}
