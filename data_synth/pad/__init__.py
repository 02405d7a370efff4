"""The simulated tactile pad: foam contact, readout, touch objects and the calibration bench."""
