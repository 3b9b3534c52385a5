//! Collects as many values as fit into a vector of fixed capacity.
use heapless::Vec;

/// As many of these as fit. `Vec`'s own `collect` and `extend` panic where there are more.
pub fn collect<T, const N: usize>(values: impl IntoIterator<Item = T>) -> Vec<T, N> {
    let mut list = Vec::new();
    for value in values {
        if list.push(value).is_err() {
            break;
        }
    }
    list
}
