//! [`state!`](crate::state): a struct, and the value with which each of its fields begins.
//!
//! In: the fields of a state, each with its first value. Out: the struct, and a constant or a
//! constructor of that state. So a field stands once, and a reader sees both together.

/// A struct whose fields have first values, then the constant or the constructor that has them.
///
/// ```
/// servo::state! {
///     /// A counter.
///     #[derive(Debug, PartialEq)]
///     struct Counter {
///         /// What was counted.
///         count: u32 = 0,
///         most: u32 = most,
///     }
///     /// Nothing was counted.
///     const fn new(most: u32);
/// }
/// assert_eq!(Counter::new(7), Counter { count: 0, most: 7 });
/// ```
#[macro_export]
macro_rules! state {
    (
        $(#[$of:meta])* $vis:vis struct $name:ident $(<$($life:lifetime)? $(,)? $(const $size:ident: usize),*>)? {
            $($(#[$about:meta])* $reach:vis $field:ident: $type:ty = $value:expr,)+
        }
        $($first:tt)+
    ) => {
        $(#[$of])*
        $vis struct $name $(<$($life,)? $(const $size: usize),*>)? {
            $($(#[$about])* $reach $field: $type,)+
        }
        impl $(<$($life,)? $(const $size: usize),*>)? $name $(<$($life,)? $($size),*>)? {
            $crate::state! { @first $($first)+ { $($field: $value,)+ } }
        }
    };
    (@first $(#[$of:meta])* $vis:vis const $name:ident; $fields:tt) => {
        $(#[$of])* $vis const $name: Self = Self $fields;
    };
    (@first $(#[$of:meta])* $vis:vis const fn $name:ident $arguments:tt; $fields:tt) => {
        $(#[$of])* $vis const fn $name $arguments -> Self { Self $fields }
    };
    (@first $(#[$of:meta])* $vis:vis fn $name:ident $arguments:tt; $fields:tt) => {
        $(#[$of])* $vis fn $name $arguments -> Self { Self $fields }
    };
}
