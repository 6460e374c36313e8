//! A scalar over a whole run in bounded memory: a curve of a few hundred columns needs the least and
//! the greatest value of each, not a million steps.

/// A scalar over a whole run: buckets of consecutive steps, each with its least and greatest value.
/// When they are too many, neighbours are joined, so the whole history stays.
#[derive(Debug, Clone, Default)]
pub struct Series {
    buckets: Vec<Bucket>,
    /// Values a bucket holds; a power of two.
    width: u32,
    last: Option<f64>,
}

#[derive(Debug, Clone, Copy)]
struct Bucket {
    /// How many values it has.
    count: u32,
    /// The times of the first and the last value.
    times: [f64; 2],
    /// The first and the last value.
    ends: [f64; 2],
    least: f64,
    greatest: f64,
}

impl Bucket {
    fn of(t: f64, value: f64) -> Self {
        Self {
            count: 1,
            times: [t; 2],
            ends: [value; 2],
            least: value,
            greatest: value,
        }
    }

    /// Takes in one that follows.
    fn join(&mut self, next: &Self) {
        self.count += next.count;
        self.times[1] = next.times[1];
        self.ends[1] = next.ends[1];
        self.least = self.least.min(next.least);
        self.greatest = self.greatest.max(next.greatest);
    }
}

/// More buckets than this are joined: twice the columns of a wide terminal.
const BUCKETS: usize = 1024;

impl Series {
    /// Adds the value at a time; times come in order.
    pub fn push(&mut self, t: f64, value: f64) {
        self.last = Some(value);
        let next = Bucket::of(t, value);
        match self.buckets.last_mut() {
            // Values at one time belong together.
            Some(bucket) if bucket.times[1] == t => bucket.join(&Bucket { count: 0, ..next }),
            Some(bucket) if bucket.count < self.width => bucket.join(&next),
            _ => self.buckets.push(next),
        }
        if self.buckets.len() > BUCKETS {
            self.width = 2 * self.width.max(1);
            let pairs = self.buckets.chunks(2).map(|pair| {
                let mut joined = pair[0];
                pair[1..].iter().for_each(|next| joined.join(next));
                joined
            });
            self.buckets = pairs.collect();
        }
    }

    /// The value at t = 0.
    pub fn at_start(&self) -> Option<f64> {
        let bucket = self.buckets.first()?;
        (bucket.times[0] == 0.0).then_some(bucket.ends[0])
    }

    /// The last value.
    pub fn last(&self) -> Option<f64> {
        self.last
    }

    /// The least and the greatest value in each of `columns` equal parts of the time from 0 to `end`, on the line
    /// through the values; `None` after the last of them.
    pub fn columns(&self, columns: usize, end: f64) -> Vec<Option<[f64; 2]>> {
        let mut out: Vec<Option<[f64; 2]>> = vec![None; columns];
        let last = columns.saturating_sub(1);
        let scale = columns as f64 / end;
        // A time that is not finite is in the first column.
        let column = |t: f64| ((t * scale).max(0.0) as usize).min(last);
        let mut before: Option<&Bucket> = None;
        for bucket in &self.buckets {
            let [from, to] = bucket.times.map(column);
            if let Some(before) = before {
                let ([_, t], [_, value]) = (before.times, before.ends);
                let slope = (bucket.ends[0] - value) / (bucket.times[0] - t);
                for (index, slot) in out.iter_mut().enumerate().take(from).skip(column(t) + 1) {
                    let between = value + slope * ((index as f64 + 0.5) / scale - t);
                    *slot = Some([between; 2]);
                }
            }
            for slot in out.iter_mut().take(to + 1).skip(from) {
                let [least, greatest] = slot.get_or_insert([bucket.least, bucket.greatest]);
                *least = least.min(bucket.least);
                *greatest = greatest.max(bucket.greatest);
            }
            before = Some(bucket);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_history_keeps_its_extremes_in_bounded_memory() {
        let mut series = Series::default();
        for step in 0..1_000_000 {
            let value = if step == 123_456 {
                -7.0
            } else {
                f64::from(step)
            };
            series.push(f64::from(step), value);
        }
        assert!(series.buckets.len() <= BUCKETS);
        let columns = series.columns(100, 1e6);
        assert_eq!(columns[12].map(|[least, _]| least), Some(-7.0));
        assert_eq!(columns[99].map(|[_, greatest]| greatest), Some(999_999.0));
        assert_eq!(
            (series.at_start(), series.last()),
            (Some(0.0), Some(999_999.0))
        );
    }

    #[test]
    fn what_has_not_happened_yet_is_empty() {
        let mut series = Series::default();
        for step in 0..=10 {
            series.push(f64::from(step), f64::from(step));
        }
        let columns = series.columns(10, 100.0);
        assert_eq!(columns[0], Some([0.0, 9.0]));
        assert_eq!(columns[1], Some([10.0, 10.0]));
        assert!(columns[2..].iter().all(Option::is_none));
    }

    /// However few values there are, and however unequal the steps between them.
    #[test]
    fn between_two_values_there_is_the_line_through_them() {
        let mut series = Series::default();
        series.push(0.0, 0.0);
        series.push(0.1, 1.0);
        series.push(10.0, 100.0);
        let columns = series.columns(10, 10.0);
        assert_eq!(columns[0], Some([0.0, 1.0]));
        for (index, column) in columns.iter().enumerate().take(9).skip(1) {
            let [least, greatest] = column.expect("no gap");
            let exact = 10.0 * (index as f64 + 0.5);
            assert!((least - exact).abs() < 1e-9 && least == greatest, "{index}");
        }
        assert_eq!(columns[9], Some([100.0; 2]));
        assert!(
            Series::default()
                .columns(3, 1.0)
                .iter()
                .all(Option::is_none)
        );
        assert!(series.columns(0, 1.0).is_empty());
        assert_eq!(series.columns(2, 0.0).len(), 2);
    }
}
