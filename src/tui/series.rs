//! A scalar over a whole run in bounded memory: a curve of a few hundred columns needs the least and
//! the greatest value of each, not a million steps.

/// A scalar over a whole run: buckets of consecutive steps, each with its least and greatest value.
/// When they are too many, neighbours are joined, so the whole history stays.
#[derive(Debug, Clone, Default)]
pub struct Series {
    buckets: Vec<Bucket>,
    /// Steps a bucket holds; a power of two.
    width: u64,
    first: Option<f64>,
    last: Option<f64>,
}

#[derive(Debug, Clone, Copy)]
struct Bucket {
    start: u64,
    least: f64,
    greatest: f64,
}

/// More buckets than this are joined: twice the columns of a wide terminal.
const BUCKETS: usize = 1024;

impl Series {
    /// Adds the value of a step; steps come in order.
    pub fn push(&mut self, step: u64, value: f64) {
        self.first.get_or_insert(value);
        self.last = Some(value);
        let width = self.width.max(1);
        match self.buckets.last_mut() {
            Some(bucket) if step - bucket.start < width => {
                bucket.least = bucket.least.min(value);
                bucket.greatest = bucket.greatest.max(value);
            }
            _ => self.buckets.push(Bucket {
                start: step - step % width,
                least: value,
                greatest: value,
            }),
        }
        if self.buckets.len() > BUCKETS {
            self.join(2 * width);
        }
    }

    /// Joins the buckets into wider ones.
    fn join(&mut self, width: u64) {
        self.width = width;
        let mut joined: Vec<Bucket> = Vec::with_capacity(BUCKETS);
        for bucket in &self.buckets {
            let start = bucket.start - bucket.start % width;
            match joined.last_mut() {
                Some(last) if last.start == start => {
                    last.least = last.least.min(bucket.least);
                    last.greatest = last.greatest.max(bucket.greatest);
                }
                _ => joined.push(Bucket { start, ..*bucket }),
            }
        }
        self.buckets = joined;
    }

    /// The value of the first step.
    pub fn first(&self) -> Option<f64> {
        self.first
    }

    /// The value of the last step.
    pub fn last(&self) -> Option<f64> {
        self.last
    }

    /// The least and the greatest value in each of `columns` equal parts of the steps 0..=`end`;
    /// `None` where there is none (yet).
    pub fn columns(&self, columns: usize, end: u64) -> Vec<Option<[f64; 2]>> {
        let mut out: Vec<Option<[f64; 2]>> = vec![None; columns];
        let scale = columns as f64 / (end + 1) as f64;
        for bucket in &self.buckets {
            let reach = bucket.start + self.width.max(1) - 1;
            let column = |step: u64| ((step as f64 * scale) as usize).min(columns.max(1) - 1);
            for slot in out
                .iter_mut()
                .take(column(reach) + 1)
                .skip(column(bucket.start))
            {
                let [least, greatest] = slot.get_or_insert([bucket.least, bucket.greatest]);
                *least = least.min(bucket.least);
                *greatest = greatest.max(bucket.greatest);
            }
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
            series.push(step, if step == 123_456 { -7.0 } else { step as f64 });
        }
        assert!(series.buckets.len() <= BUCKETS);
        let columns = series.columns(100, 999_999);
        assert_eq!(columns[12].map(|[least, _]| least), Some(-7.0));
        assert_eq!(columns[99].map(|[_, greatest]| greatest), Some(999_999.0));
        assert_eq!(
            (series.first(), series.last()),
            (Some(0.0), Some(999_999.0))
        );
    }

    #[test]
    fn what_has_not_happened_yet_is_empty() {
        let mut series = Series::default();
        for step in 0..=10 {
            series.push(step, step as f64);
        }
        let columns = series.columns(10, 99);
        assert_eq!(columns[0], Some([0.0, 9.0]));
        assert_eq!(columns[1], Some([10.0, 10.0]));
        assert!(columns[2..].iter().all(Option::is_none));
    }
}
