from ._ballservo import Ball as Ball, Camera as Camera, Colors as Colors, Detector as Detector
from ._ballservo import InputError as InputError, Run as Run, Scenario as Scenario, Tracker as Tracker
from ._ballservo import simulate as simulate

__all__ = ["Ball", "Camera", "Colors", "Detector", "InputError", "Run", "Scenario", "Tracker", "simulate"]
