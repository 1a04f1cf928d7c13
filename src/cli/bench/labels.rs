//! Where the names of a chart's dots go, so that none collides with another, with a dot or a line.

/// Of a letter: width, and height of its line.
const LETTER: [f64; 2] = [6.9, 13.0];

/// A rectangle, in pixels; y points down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Area {
    pub(crate) low: [f64; 2],
    pub(crate) high: [f64; 2],
}

impl Area {
    fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|i| self.low[i] < other.high[i] && other.low[i] < self.high[i])
    }
}

/// Areas along a line, to keep it clear.
pub(crate) fn along(from: [f64; 2], to: [f64; 2]) -> impl Iterator<Item = Area> {
    const STEP: f64 = 3.0;
    let delta = [to[0] - from[0], to[1] - from[1]];
    let steps = (delta[0].abs().max(delta[1].abs()) / STEP).ceil().max(1.0);
    (0..=steps as u32).map(move |i| {
        let part = f64::from(i) / steps;
        let place = [0, 1].map(|k: usize| from[k] + delta[k] * part);
        Area { low: place.map(|c| c - 2.0), high: place.map(|c| c + 2.0) }
    })
}

/// Where a name goes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Label {
    pub(crate) area: Area,
    /// Where a line from the dot ends, if the name is not beside it.
    pub(crate) pole: Option<[f64; 2]>,
}

/// Places for the names of dots, in a panel of `size`: beside the dot, or if nothing is free there,
/// above it like a flag on its pole. `taken` is what names must keep off beside dots and each other.
pub(crate) fn labels(
    dots: &[([f64; 2], &str)],
    mut taken: Vec<Area>,
    size: [f64; 2],
) -> Vec<Label> {
    const DOT: f64 = 6.0;
    taken.extend(
        dots.iter().map(|([x, y], _)| Area { low: [x - DOT, y - DOT], high: [x + DOT, y + DOT] }),
    );
    // From the right: poles to the left of a flag do not cross it.
    let mut order: Vec<usize> = (0..dots.len()).collect();
    order.sort_by(|i, j| dots[*j].0[0].total_cmp(&dots[*i].0[0]));
    let mut found: Vec<(usize, Label)> = Vec::new();
    for i in order {
        let (dot, name) = dots[i];
        let length = [LETTER[0] * name.chars().count() as f64, LETTER[1]];
        let is_free = |label: &Label| {
            let Area { low, high } = label.area;
            let inside = (0..2).all(|i| low[i] >= 2.0 && high[i] <= size[i] - 2.0);
            let crosses = |end: [f64; 2]| {
                let pole = Area { low: [dot[0] - 1.0, end[1]], high: [dot[0] + 1.0, dot[1]] };
                found.iter().any(|(_, other)| other.area.overlaps(&pole))
            };
            inside
                && !taken.iter().any(|other| label.area.overlaps(other))
                && !label.pole.is_some_and(crosses)
        };
        let nothing = Label { area: Area { low: dot, high: dot }, pole: None };
        let label = candidates(dot, length).find(is_free).unwrap_or(nothing);
        taken.push(label.area);
        if let Some(end) = label.pole {
            taken.extend(along(dot, end));
        }
        found.push((i, label));
    }
    found.sort_by_key(|(i, _)| *i);
    found.into_iter().map(|(_, label)| label).collect()
}

/// Places for a name, the best first.
fn candidates(dot: [f64; 2], [width, height]: [f64; 2]) -> impl Iterator<Item = Label> {
    /// From a dot to a name beside it.
    const GAP: f64 = 9.0;
    let area = move |x: f64, y: f64| Area { low: [x, y], high: [x + width, y + height] };
    let [x, y] = dot;
    let beside = [
        [x + GAP, y - height / 2.0],
        [x + GAP, y + 1.0],
        [x + GAP, y - height - 1.0],
        [x - width / 2.0, y + GAP],
        [x - width - GAP, y - height / 2.0],
    ];
    let flags = (0..200).map(move |step| {
        let bottom = y - 14.0 - 2.0 * f64::from(step);
        Label { area: area(x - 1.0, bottom - height), pole: Some([x, bottom]) }
    });
    beside.into_iter().map(move |[x, y]| Label { area: area(x, y), pole: None }).chain(flags)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_collide_with_nothing() {
        // Two heaps of dots, and a line through them.
        let dots: Vec<([f64; 2], &str)> = (0..11)
            .map(|i| [20.0 + f64::from(i % 2) * 200.0 + 4.0 * f64::from(i), 200.0])
            .map(|place| (place, "affine-polygon"))
            .collect();
        let line: Vec<Area> = along([10.0, 200.0], [300.0, 230.0]).collect();
        let labels = labels(&dots, line.clone(), [450.0, 300.0]);
        for (i, Label { area, .. }) in labels.iter().enumerate() {
            assert!(labels[..i].iter().all(|other| !area.overlaps(&other.area)), "{i}: {area:?}");
            assert!(line.iter().all(|part| !area.overlaps(part)), "{i}: {area:?}");
            assert!(area.high[0] - area.low[0] > 90.0, "{i} has no place");
            assert!(area.low.iter().all(|c| *c >= 0.0) && area.high[0] <= 450.0);
            for ([x, y], _) in &dots {
                let dot = Area { low: [x - 4.0, y - 4.0], high: [x + 4.0, y + 4.0] };
                assert!(!area.overlaps(&dot), "{i}: {area:?}");
            }
        }
    }
}
