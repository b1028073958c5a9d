//! Case files, process and protocol of OpenFOAM's `pimpleFoam`.
