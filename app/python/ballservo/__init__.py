"""ballservo: a robot sees a coloured ball, places it in 3-D and drives to it.

    import ballservo
    tracker = ballservo.Tracker(colors="my.colors", camera="camera.yaml", diameter="0.07")
    for ball in tracker.update(bgr, time_s):
        print(ball.track_id, ball.p_m, ball.covariance_m2)
"""

__all__ = ["Ball", "Camera", "CameraCalibration", "Colors", "Detector", "Frame", "InputError", "Run", "Scenario",
           "Step", "Sweep", "Tracker", "calibrate_camera", "compare", "simulate", "sweep"]


def __getattr__(name):  # the pages are drawn without loading the library
    if name not in __all__:
        raise AttributeError(f"module 'ballservo' has no attribute '{name}'")
    from . import _ballservo
    return getattr(_ballservo, name)


def __dir__():
    return __all__
