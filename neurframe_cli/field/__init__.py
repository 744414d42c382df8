"""The frame field: spherical harmonics, frames, energy, network, singular graph."""
