"""Files of other codes that describe beams by the matrices of their sections."""
