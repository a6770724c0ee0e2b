//! Files that others wrote: opened only if they are files, read within bounds, tables of numbers by one reader.
//!
//! Whatever path a user names may be a pipe that nobody writes to, a device without an end, or a file of any size. Every
//! program opens what it was given through [`open`] or [`read_text`], and reads tables through [`read_columns`], so that
//! each command refuses the same things in the same words.

mod file;
mod marks;
mod table;
mod text;

pub use file::{open, read_text};
pub use marks::{Marks, has_thousands};
pub use table::{Column, Labelled, OtherColumns, TableError, preamble, read_columns, read_labelled, with_point};
pub use text::{decoded, one_line, visible};
