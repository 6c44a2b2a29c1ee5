//! Triangles near a place. O(T log T) to build for T triangles; cannot fail.

use crate::num::Vec3;

/// Triangles sorted into cells by their bounding boxes.
pub struct Bins {
    low: Vec3,
    cell: f64,
    size: [usize; 3],
    start: Vec<u32>,
    faces: Vec<u32>,
}

impl Bins {
    /// Sorts `faces` into cells of `cell`, m, or larger ones if they would be many more than `work`.
    pub fn new(faces: &[[Vec3; 3]], cell: f64, work: usize) -> Self {
        let corners = || faces.iter().flatten();
        let low = corners().fold(Vec3::repeat(f64::INFINITY), |low, p| low.inf(p));
        let high = corners().fold(Vec3::repeat(f64::NEG_INFINITY), |high, p| high.sup(p));
        let mut bins = Self { low, cell, size: [1; 3], start: Vec::new(), faces: Vec::new() };
        let most = 4.0 * work as f64 + 64.0;
        loop {
            let size: [f64; 3] =
                std::array::from_fn(|axis| ((high[axis] - low[axis]) / bins.cell).floor() + 1.0);
            if size.iter().product::<f64>() <= most {
                bins.size = size.map(|n| n as usize);
                break;
            }
            bins.cell *= 1.25;
        }
        let mut entries = Vec::new();
        for (index, [a, b, c]) in faces.iter().enumerate() {
            bins.cells(&a.inf(b).inf(c), &a.sup(b).sup(c), |cell| {
                entries.push((cell as u32, index as u32));
            });
        }
        entries.sort_unstable();
        bins.start = vec![0; bins.size.iter().product::<usize>() + 1];
        for (cell, _) in &entries {
            bins.start[*cell as usize + 1] += 1;
        }
        for cell in 1..bins.start.len() {
            bins.start[cell] += bins.start[cell - 1];
        }
        bins.faces = entries.into_iter().map(|entry| entry.1).collect();
        bins
    }

    fn cells(&self, low: &Vec3, high: &Vec3, mut visit: impl FnMut(usize)) {
        let along = |axis: usize, x: f64| {
            (((x - self.low[axis]) / self.cell) as usize).min(self.size[axis] - 1)
        };
        let from: [usize; 3] = std::array::from_fn(|axis| along(axis, low[axis]));
        let to: [usize; 3] = std::array::from_fn(|axis| along(axis, high[axis]));
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                for x in from[0]..=to[0] {
                    visit(x + self.size[0] * (y + self.size[1] * z));
                }
            }
        }
    }

    /// Triangles whose cells the box of half-width `range` about `place` meets, rising.
    pub fn near(&self, place: &Vec3, range: f64, found: &mut Vec<u32>) {
        let reach = Vec3::repeat(range);
        self.cells(&(place - reach), &(place + reach), |cell| {
            let (from, to) = (self.start[cell] as usize, self.start[cell + 1] as usize);
            found.extend_from_slice(&self.faces[from..to]);
        });
        found.sort_unstable();
        found.dedup();
    }
}
