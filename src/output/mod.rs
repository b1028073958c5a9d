//! What a run leaves: VTU/PVD, CSV, JSON.
