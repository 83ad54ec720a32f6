//! Integration tests: one binary, so that one device serves all.

mod adversarial;
mod assisted;
mod bench;
mod binned;
mod cli;
mod collapse;
mod device;
mod gpu;
mod grid;
mod layers;
mod layout;
mod lbvh;
mod matrix;
mod morton;
mod oracle;
mod ploc;
mod quality;
mod rays;
mod raysort;
mod scan;
mod scene;
mod shaders;
mod sort;
mod soup;
mod strategies;
mod trace;
