from ._ballservo import Ball as Ball, Camera as Camera, CameraCalibration as CameraCalibration, Colors as Colors
from ._ballservo import Detector as Detector, Frame as Frame, InputError as InputError, Run as Run, Scenario as Scenario
from ._ballservo import Step as Step, Sweep as Sweep, Tracker as Tracker, calibrate_camera as calibrate_camera
from ._ballservo import compare as compare, simulate as simulate, sweep as sweep

__all__ = ["Ball", "Camera", "CameraCalibration", "Colors", "Detector", "Frame", "InputError", "Run", "Scenario",
           "Step", "Sweep", "Tracker", "calibrate_camera", "compare", "simulate", "sweep"]
