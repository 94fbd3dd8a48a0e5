#![allow(non_snake_case)]
mod contact_data;
mod npz;
