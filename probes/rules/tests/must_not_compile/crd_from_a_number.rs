//! A coordinate system that is not checked against the capacity.
fn main() {
    let _ = servo::units::Crd(200);
}
