//! Charts as SVG text: lines on linear or logarithmic axes, bars.
//!
//! No script, no fonts of their own, axes in the colour of the text around
//! (`currentColor`), so that they read on white and on black. Same numbers in,
//! same text out. Values that are not finite, and values ≤ 0 on a logarithmic
//! axis, interrupt a line.

use super::colour::SERIES;
use super::number;
use std::fmt::Write;

/// Width of every chart, in SVG units.
const WIDTH: f64 = 640.0;
const LEFT: f64 = 78.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 14.0;
/// Decades that a logarithmic axis shows at most; smaller values are left out.
const DECADES: f64 = 20.0;
/// Points of a line beyond which it is thinned.
const DENSE: usize = 800;
const DASHES: [&str; 6] = ["", "7 3", "2 3", "9 3 2 3", "4 2", "1 2"];

/// An axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axis {
    /// What it shows.
    pub label: String,
    /// SI unit; the axis chooses a prefix (linear axes only). Empty for pure numbers.
    pub unit: String,
    /// Logarithmic.
    pub log: bool,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: &str, unit: &str) -> Self {
        Self { label: label.into(), unit: unit.into(), log: false }
    }

    /// A logarithmic axis.
    pub fn log(label: &str, unit: &str) -> Self {
        Self { log: true, ..Self::linear(label, unit) }
    }
}

/// One line.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// x and y; intervals where made by [`Series::intervals`].
    pub points: Vec<(f64, f64)>,
    /// Draw a dot at each point: for measurements rather than histories.
    pub dots: bool,
}

impl Series {
    /// Values with intervals: x, value, half of the interval. Each is four points: the value, both
    /// ends, and one that is not finite.
    pub fn intervals(name: &str, values: impl Iterator<Item = (f64, f64, f64)>) -> Self {
        let ends = values.map(|(x, y, half)| (x, y, y - half, y + half));
        Self::with_ends(name, ends)
    }

    /// Values with bars that reach up: x, value, upper end.
    pub fn up_to(name: &str, values: impl Iterator<Item = (f64, f64, f64)>) -> Self {
        Self::with_ends(name, values.map(|(x, y, top)| (x, y, y, top)))
    }

    fn with_ends(name: &str, values: impl Iterator<Item = (f64, f64, f64, f64)>) -> Self {
        let points = values
            .flat_map(|(x, y, low, high)| [(x, y), (x, low), (x, high), (f64::NAN, f64::NAN)]);
        Self { name: name.into(), points: points.collect(), dots: true }
    }

    /// Points without the ends of intervals.
    fn values(&self) -> Vec<(f64, f64)> {
        match self.ends() {
            Some(ends) => ends.iter().map(|[value, _, _]| *value).collect(),
            None => self.points.clone(),
        }
    }

    /// Values and the ends of their intervals, if this is a series of intervals.
    fn ends(&self) -> Option<Vec<[(f64, f64); 3]>> {
        let (quads, rest) = self.points.as_chunks::<4>();
        let sound = |q: &[(f64, f64); 4]| {
            q[0].0 == q[1].0
                && q[0].0 == q[2].0
                && q[3].0.is_nan()
                && q[1].1 <= q[0].1
                && q[0].1 <= q[2].1
        };
        let all = !quads.is_empty() && rest.is_empty() && quads.iter().all(sound);
        all.then(|| quads.iter().map(|[value, low, high, _]| [*value, *low, *high]).collect())
    }
}

/// A chart of lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// What it shows, for the heading and for readers that cannot see it.
    pub title: String,
    /// Below the chart.
    pub caption: String,
    /// Across.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// Lines; after six, colours come again with other dashes and hollow dots.
    pub series: Vec<Series>,
    /// A value of y to mark across the chart, with its name.
    pub mark: Option<(f64, String)>,
}

/// A chart of horizontal bars.
#[derive(Debug, Clone, PartialEq)]
pub struct Bars {
    /// What it shows.
    pub title: String,
    /// Below the chart.
    pub caption: String,
    /// SI unit of the values.
    pub unit: String,
    /// Name and value of each bar; values less than 0 or not finite are left out.
    pub bars: Vec<(String, f64)>,
}

/// True for what a chart can show: leaves room so that sums and powers stay finite.
fn drawable(value: f64, log: bool) -> bool {
    value.abs() < 1e290 && (!log || value > 1e-290)
}

/// Maps values of one axis to SVG units and knows its ticks.
struct Scale {
    low: f64,
    high: f64,
    log: bool,
    from: f64,
    to: f64,
    /// SI prefix and its factor.
    prefix: (&'static str, f64),
}

impl Scale {
    fn new(axis: &Axis, values: impl Iterator<Item = f64>, from: f64, to: f64) -> Option<Self> {
        let usable = values.filter(|v| drawable(*v, axis.log));
        let (low, high) = usable
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        if low > high {
            return None;
        }
        let mut scale = Self { low, high, log: axis.log, from, to, prefix: ("", 1.0) };
        if axis.log {
            let top = high.log10().ceil();
            scale.low = 10_f64.powf(low.log10().floor().clamp(top - DECADES, top - 1.0));
            scale.high = 10_f64.powf(top);
        } else {
            scale.prefix = number::prefix(low.abs().max(high.abs()), &axis.unit);
            if high - low <= 1e-12 * high.abs().max(low.abs()) {
                // Counts and sizes do not go below 0.
                let pad = 0.1 * high.abs();
                (scale.low, scale.high) =
                    if high == 0.0 { (0.0, 1.0) } else { (low - pad, high + pad) };
            }
        }
        Some(scale)
    }

    /// Widens a linear axis to whole ticks.
    fn widened(mut self, count: usize) -> Self {
        if !self.log {
            let step = tick_step(self.high - self.low, count);
            self.low = (self.low / step + 1e-9).floor() * step;
            self.high = (self.high / step - 1e-9).ceil() * step;
        }
        self
    }

    fn place(&self, value: f64) -> f64 {
        let fraction = if self.log {
            (value.log10() - self.low.log10()) / (self.high.log10() - self.low.log10())
        } else {
            (value - self.low) / (self.high - self.low)
        };
        self.from + (self.to - self.from) * fraction
    }

    fn shows(&self, value: f64) -> bool {
        drawable(value, self.log) && (!self.log || value >= self.low)
    }

    /// Value and text of each tick.
    fn ticks(&self, count: usize) -> Vec<(f64, String)> {
        if self.log {
            let (low, high) = (self.low.log10().round() as i32, self.high.log10().round() as i32);
            let stride = ((high - low) as usize).div_ceil(count.max(1)).max(1);
            let parts: &[f64] = match high - low {
                1 => &[1.0, 2.0, 5.0],
                2 => &[1.0, 3.0],
                _ => &[1.0],
            };
            // As people write them where they do so without powers.
            let plain = low >= -2 && high <= 4;
            return (low..=high)
                .step_by(stride)
                .flat_map(|power| parts.iter().map(move |part| (*part, power)))
                .filter(|(part, power)| *power < high || *part == 1.0)
                .map(|(part, power)| {
                    let text = power_of_ten(power);
                    let text = match (part == 1.0, power) {
                        _ if plain => {
                            format!("{:.*}", -power.min(0) as usize, part * 10_f64.powi(power))
                        }
                        (true, _) => text,
                        (false, _) => format!("{part} · {text}"),
                    };
                    (part * 10_f64.powi(power), text)
                })
                .collect();
        }
        let step = tick_step(self.high - self.low, count);
        let (first, last) =
            ((self.low / step - 1e-6).ceil() as i64, (self.high / step + 1e-6).floor() as i64);
        let decimals = decimals(step / self.prefix.1);
        (first..=last)
            .map(|at| {
                let value = at as f64 * step;
                let shown = value / self.prefix.1;
                let plain = shown.abs() < 1e5 && decimals <= 4;
                let text = if plain || at == 0 {
                    format!("{shown:.*}", if at == 0 { 0 } else { decimals })
                } else {
                    number::significant(shown, 4)
                };
                (value, text)
            })
            .collect()
    }

    fn title(&self, axis: &Axis) -> String {
        match (axis.unit.as_str(), self.prefix.0) {
            ("", _) => axis.label.clone(),
            (unit, prefix) => format!("{}, {prefix}{unit}", axis.label),
        }
    }
}

/// 1, 2 or 5 times a power of ten, so that about `count` steps make `range`.
fn tick_step(range: f64, count: usize) -> f64 {
    let rough = range / count as f64;
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0].into_iter().find(|s| rough <= s * power * 1.0001).unwrap_or(10.0);
    step * power
}

fn decimals(step: f64) -> usize {
    (-(step * 1.0001).log10().floor()).max(0.0) as usize
}

fn power_of_ten(power: i32) -> String {
    match power {
        0 => "1".into(),
        1 => "10".into(),
        _ => {
            let digit = |c: char| match c {
                '-' => '⁻',
                '1' => '¹',
                '2' => '²',
                '3' => '³',
                // The other superscript digits stand in a row in Unicode.
                _ => char::from_u32(0x2070 + c as u32 - '0' as u32).unwrap_or(c),
            };
            format!("10{}", power.to_string().chars().map(digit).collect::<String>())
        }
    }
}

/// Text with the characters that XML reserves written out.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A coordinate: two decimals, no negative zero.
fn c(value: f64) -> String {
    let text = format!("{value:.1}");
    number::trimmed(if text == "-0.0" { "0" } else { &text }).to_owned()
}

impl Chart {
    /// The chart as an `<svg>` element; `None` if there is nothing to show.
    pub fn svg(&self) -> Option<String> {
        let legend = legend_rows(&self.series);
        let top = TOP + 17.0 * legend.len() as f64;
        let (bottom, height) = (top + 230.0, top + 230.0 + 42.0);
        let points = || self.series.iter().flat_map(|series| &series.points);
        let x = Scale::new(&self.x, points().map(|p| p.0), LEFT, WIDTH - RIGHT)?;
        let drawn = points().filter(|p| x.shows(p.0)).map(|p| p.1);
        let y = Scale::new(&self.y, drawn.chain(self.mark.iter().map(|m| m.0)), bottom, top)?;
        let y = y.widened(5);
        let mut svg = open(&self.title, height);
        self.axes(&mut svg, &x, &y, top, bottom);
        if let Some((value, name)) = self.mark.as_ref().filter(|(value, _)| y.shows(*value)) {
            mark(&mut svg, y.place(*value), name);
        }
        let colour = |index: usize| SERIES[index % SERIES.len()];
        let drawn: Vec<Vec<(f64, f64)>> = self.series.iter().map(Series::values).collect();
        for (index, series) in self.series.iter().enumerate() {
            for ends in series.ends().iter().flatten() {
                whisker(&mut svg, ends, &x, &y, colour(index));
            }
            for path in paths(&drawn[index], &x, &y) {
                // Writing into a String cannot fail.
                let _ = write!(
                    svg,
                    r#"<polyline fill="none" stroke="{}" stroke-width="1.8" stroke-linejoin="round"{} points="{path}"/>"#,
                    colour(index),
                    dash(index),
                );
            }
        }
        for (index, points) in drawn.iter().enumerate().filter(|(i, _)| self.series[*i].dots) {
            dots(&mut svg, points, &x, &y, index);
        }
        for (row, entries) in legend.iter().enumerate() {
            for (index, left) in entries {
                key(&mut svg, *index, *left, 12.0 + 17.0 * row as f64, &self.series[*index].name);
            }
        }
        svg.push_str("</svg>");
        Some(svg)
    }

    fn axes(&self, svg: &mut String, x: &Scale, y: &Scale, top: f64, bottom: f64) {
        // Writing into a String cannot fail.
        for (value, text) in y.ticks(5) {
            let at = c(y.place(value));
            let _ = write!(
                svg,
                r#"<path stroke="currentColor" stroke-opacity=".15" d="M{} {at}H{}"/><text x="{}" y="{at}" dy=".33em" text-anchor="end">{text}</text>"#,
                c(LEFT),
                c(WIDTH - RIGHT),
                c(LEFT - 6.0),
            );
        }
        for (value, text) in x.ticks(7) {
            let at = c(x.place(value));
            let _ = write!(
                svg,
                r#"<path stroke="currentColor" stroke-opacity=".6" d="M{at} {}v4"/><text x="{at}" y="{}" text-anchor="middle">{text}</text>"#,
                c(bottom),
                c(bottom + 17.0),
            );
        }
        let _ = write!(
            svg,
            r#"<path stroke="currentColor" stroke-opacity=".6" fill="none" d="M{l} {t}V{b}H{r}"/><text x="{m}" y="{ty}" text-anchor="middle">{xt}</text><text transform="translate(13 {my}) rotate(-90)" text-anchor="middle">{yt}</text>"#,
            l = c(LEFT),
            t = c(top),
            b = c(bottom),
            r = c(WIDTH - RIGHT),
            m = c((LEFT + WIDTH - RIGHT) / 2.0),
            ty = c(bottom + 36.0),
            my = c((top + bottom) / 2.0),
            xt = escaped(&x.title(&self.x)),
            yt = escaped(&y.title(&self.y)),
        );
    }
}

fn open(title: &str, height: f64) -> String {
    format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {} {}" role="img" aria-label="{}" font-family="system-ui, sans-serif" font-size="12" fill="currentColor">"#,
        c(WIDTH),
        c(height),
        escaped(title)
    )
}

fn dash(index: usize) -> String {
    // Where colours come again, dashes are others.
    match DASHES[(index + index / SERIES.len()) % DASHES.len()] {
        "" => String::new(),
        dash => format!(r#" stroke-dasharray="{dash}""#),
    }
}

/// Full dots, hollow ones where colours come again.
fn dots(svg: &mut String, points: &[(f64, f64)], x: &Scale, y: &Scale, index: usize) {
    let colour = SERIES[index % SERIES.len()];
    let ink = match index < SERIES.len() {
        true => format!(r#"fill="{colour}""#),
        false => format!(r#"fill="none" stroke="{colour}" stroke-width="1.4""#),
    };
    for (px, py) in points.iter().filter(|(px, py)| x.shows(*px) && y.shows(*py)) {
        let (cx, cy) = (c(x.place(*px)), c(y.place(*py)));
        let _ = write!(svg, r#"<circle cx="{cx}" cy="{cy}" r="3.4" {ink}/>"#);
    }
}

/// The bar of an interval with its ends; an end that the chart cannot show is cut at the value.
fn whisker(svg: &mut String, ends: &[(f64, f64); 3], x: &Scale, y: &Scale, colour: &str) {
    let [value, low, high] = ends;
    if !(x.shows(value.0) && y.shows(value.1)) {
        return;
    }
    let at = |end: f64| c(y.place(if y.shows(end) { end } else { value.1 }));
    let (left, right) = (c(x.place(value.0) - 4.0), c(x.place(value.0) + 4.0));
    let (place, low, high) = (c(x.place(value.0)), at(low.1), at(high.1));
    // Writing into a String cannot fail.
    let _ = write!(
        svg,
        r#"<path stroke="{colour}" stroke-width="1.4" d="M{left} {low}H{right}M{place} {low}V{high}M{left} {high}H{right}"/>"#
    );
}

fn mark(svg: &mut String, at: f64, name: &str) {
    let _ = write!(
        svg,
        r##"<path stroke="#c0392b" stroke-dasharray="3 3" d="M{} {y}H{}"/><text x="{}" y="{}" fill="#c0392b" text-anchor="end">{}</text>"##,
        c(LEFT),
        c(WIDTH - RIGHT),
        c(WIDTH - RIGHT - 4.0),
        c(at - 4.0),
        escaped(name),
        y = c(at),
    );
}

/// Rows of (series, left edge) such that no name runs out of the chart.
fn legend_rows(series: &[Series]) -> Vec<Vec<(usize, f64)>> {
    let mut rows: Vec<Vec<(usize, f64)>> = Vec::new();
    let mut left = f64::INFINITY;
    for (index, series) in series.iter().enumerate() {
        let width = 36.0 + 7.0 * series.name.chars().count() as f64;
        if left + width > WIDTH - RIGHT {
            rows.push(Vec::new());
            left = LEFT;
        }
        if let Some(row) = rows.last_mut() {
            row.push((index, left));
        }
        left += width;
    }
    rows
}

fn key(svg: &mut String, index: usize, left: f64, y: f64, name: &str) {
    let _ = write!(
        svg,
        r#"<path stroke="{}" stroke-width="2.2"{} d="M{} {}h22"/><text x="{}" y="{}">{}</text>"#,
        SERIES[index % SERIES.len()],
        dash(index),
        c(left),
        c(y - 4.0),
        c(left + 27.0),
        c(y),
        escaped(name)
    );
}

/// The pieces of a line as lists of points, thinned to the lowest and highest
/// value in each of [`DENSE`]/2 columns where it is denser than that.
fn paths(points: &[(f64, f64)], x: &Scale, y: &Scale) -> Vec<String> {
    points
        .split(|(px, py)| !(x.shows(*px) && y.shows(*py)))
        .filter(|piece| !piece.is_empty())
        .map(|piece| {
            let mut text = String::new();
            for (px, py) in thinned(piece) {
                let _ = write!(text, "{},{} ", c(x.place(px)), c(y.place(py)));
            }
            if piece.len() == 1 {
                // A lone point would be invisible: a short dash stands for it.
                let (px, py) = piece[0];
                let _ = write!(text, "{},{} ", c(x.place(px) + 3.0), c(y.place(py)));
            }
            text.trim_end().to_owned()
        })
        .collect()
}

fn thinned(piece: &[(f64, f64)]) -> Vec<(f64, f64)> {
    if piece.len() <= DENSE {
        return piece.to_vec();
    }
    let mut kept = Vec::with_capacity(DENSE + 2);
    kept.push(piece[0]);
    for chunk in piece.chunks(piece.len().div_ceil(DENSE / 2)) {
        // A chunk is never empty: its extremes are entries of it.
        let extreme = |wanted: fn(f64, f64) -> bool| {
            (1..chunk.len())
                .fold(0, |best, at| if wanted(chunk[at].1, chunk[best].1) { at } else { best })
        };
        let (low, high) = (extreme(|a, b| a < b), extreme(|a, b| a > b));
        kept.push(chunk[low.min(high)]);
        if low != high {
            kept.push(chunk[low.max(high)]);
        }
    }
    kept.push(piece[piece.len() - 1]);
    kept
}

impl Bars {
    /// The chart as an `<svg>` element; `None` if there is nothing to show.
    pub fn svg(&self) -> Option<String> {
        let shown: Vec<&(String, f64)> =
            self.bars.iter().filter(|(_, value)| value.is_finite() && *value >= 0.0).collect();
        let most = shown.iter().map(|(_, value)| *value).reduce(f64::max)?;
        let names = shown.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
        let left = (12.0 + 6.6 * names as f64).min(WIDTH * 0.45);
        let room = WIDTH - left - 110.0;
        let mut svg = open(&self.title, 12.0 + 26.0 * shown.len() as f64);
        for (row, (name, value)) in shown.iter().enumerate() {
            let y = 8.0 + 26.0 * row as f64;
            let length = if most > 0.0 { room * value / most } else { 0.0 };
            let _ = write!(
                svg,
                r#"<text x="{}" y="{ty}" text-anchor="end">{}</text><rect x="{}" y="{}" width="{}" height="18" rx="2" fill="{}"/><text x="{}" y="{ty}">{}</text>"#,
                c(left - 8.0),
                escaped(name),
                c(left),
                c(y),
                c(length.max(1.0)),
                SERIES[row % SERIES.len()],
                c(left + length + 7.0),
                escaped(&number::with_unit(*value, &self.unit)),
                ty = c(y + 13.0),
            );
        }
        svg.push_str("</svg>");
        Some(svg)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Panics unless every tag of `text` is closed in the right order.
    pub fn assert_balanced(text: &str) {
        let mut open = Vec::new();
        for piece in text.split('<').skip(1) {
            let tag = piece.split('>').next().expect("split gives a first part");
            let name = tag.split([' ', '/', '\n']).find(|n| !n.is_empty()).expect("a name");
            if let Some(closed) = tag.strip_prefix('/') {
                assert_eq!(open.pop(), Some(closed.trim()), "in {text:.200}");
            } else if !tag.ends_with('/') && !tag.starts_with('!') && !VOID.contains(&name) {
                open.push(name);
            }
        }
        assert!(open.is_empty(), "never closed: {open:?}");
    }

    /// HTML elements that have no end.
    const VOID: [&str; 6] = ["meta", "img", "br", "hr", "link", "input"];

    fn chart(log: bool, points: Vec<(f64, f64)>) -> Chart {
        let y = if log { Axis::log("difference", "m") } else { Axis::linear("energy", "J") };
        Chart {
            title: "a < b & \"c\"".into(),
            caption: String::new(),
            x: Axis::linear("time", "s"),
            y,
            series: vec![Series { name: "one <1>".into(), points, dots: true }],
            mark: Some((1e-3, "tolerance".into())),
        }
    }

    #[test]
    fn charts_are_sound_whatever_goes_in() {
        let cases: Vec<Vec<(f64, f64)>> = vec![
            vec![(0.0, 0.0)],
            vec![(0.0, 1.0), (1.0, 1.0)],
            vec![(0.0, f64::NAN), (1.0, 2.0), (2.0, f64::INFINITY), (3.0, -4.0)],
            vec![(0.0, 1e-300), (1.0, 1e300)],
            vec![(5.0, 1e-9), (5.0, 2e-9)],
            (0..5000).map(|i| (i as f64, (i as f64 * 0.1).sin())).collect(),
        ];
        for points in cases {
            for log in [false, true] {
                if let Some(svg) = chart(log, points.clone()).svg() {
                    assert_balanced(&svg);
                    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
                    assert!(
                        svg.split("<circle").next().expect("a first part").len() < 40_000,
                        "thinned"
                    );
                }
            }
        }
        assert_eq!(Chart { mark: None, ..chart(false, vec![]) }.svg(), None);
    }

    #[test]
    fn intervals_are_bars_with_a_dot() {
        let values = [(1.0, 0.5, 0.2), (2.0, -0.1, 0.3)];
        let mut all = chart(false, vec![]);
        all.series = vec![Series::intervals("a", values.into_iter())];
        let svg = all.svg().expect("two values");
        assert_balanced(&svg);
        assert_eq!((svg.matches("<circle").count(), svg.matches("<polyline").count()), (2, 1));
        assert_eq!(svg.matches(r#"stroke-width="1.4""#).count(), 2);
        all.y = Axis::log("error", "");
        all.series = vec![Series::up_to("a", [(1.0, 0.5, 0.9)].into_iter())];
        let svg = all.svg().expect("one value");
        assert_eq!(svg.matches(r#"stroke-width="1.4""#).count(), 1);
    }

    #[test]
    fn ticks_are_round_numbers() {
        let axis = Axis::linear("energy", "J");
        let scale = Scale::new(&axis, [0.0, 0.00234].into_iter(), 0.0, 1.0).expect("a range");
        let scale = scale.widened(5);
        let texts: Vec<String> = scale.ticks(5).into_iter().map(|tick| tick.1).collect();
        assert_eq!(texts, ["0", "0.5", "1.0", "1.5", "2.0", "2.5"]);
        assert_eq!(scale.title(&axis), "energy, mJ");
        let axis = Axis::log("difference", "");
        let scale = Scale::new(&axis, [3e-13, 0.2].into_iter(), 0.0, 1.0).expect("a range");
        let texts: Vec<String> = scale.ticks(5).into_iter().map(|tick| tick.1).collect();
        assert_eq!(texts, ["10⁻¹³", "10⁻¹⁰", "10⁻⁷", "10⁻⁴", "10⁻¹"]);
    }

    #[test]
    fn thinning_keeps_peaks_and_ends() {
        let mut points: Vec<(f64, f64)> = (0..10_000).map(|i| (i as f64, 0.0)).collect();
        points[4321].1 = 7.0;
        let kept = thinned(&points);
        assert!(kept.len() <= DENSE + 2);
        assert!(kept.contains(&(4321.0, 7.0)));
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[9999]));
    }

    #[test]
    fn bars_name_their_values() {
        let bars = Bars {
            title: "cost".into(),
            caption: String::new(),
            unit: "s".into(),
            bars: vec![("ours".into(), 0.5), ("bad".into(), f64::NAN), ("YADE".into(), 4.0)],
        };
        let svg = bars.svg().expect("two bars");
        assert_balanced(&svg);
        assert!(svg.contains("500 ms") && svg.contains("4 s") && !svg.contains("bad"));
        assert_eq!(Bars { bars: vec![], ..bars }.svg(), None);
    }
}
