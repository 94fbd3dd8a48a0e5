//! The commands, one file each.

pub mod check;
pub mod compare;
pub mod convert;
pub mod export;
pub mod inspect;
pub mod make;
pub mod render;
pub mod replay;
pub mod scenes;
pub mod simulate;
pub mod solve;
pub mod stability;
pub mod view;
