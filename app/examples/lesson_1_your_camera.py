"""Lesson 1, your camera: from pictures of a board to a camera file, and how far to trust it.

A camera turns points in space into pixels. Its parameters (focal lengths, principal point, lens) are found from
pictures of a flat board whose corners are where we know. Here a camera that we know photographs the board, so that
we can see how wrong the answer is.  Run it: PYTHONPATH=build/release/python python3 app/examples/lesson_1_your_camera.py
"""
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

import ballservo

DATA = Path(__file__).resolve().parents[2] / "data"
truth = ballservo.Camera.load(DATA / "cameras/wide.yaml")
print("the camera:", truth.model, truth.parameters)

# A board: 10 x 7 squares of 25 mm, 40 px of its drawing each, and a white margin of one square.
SQUARE_M, SQUARE_PX = 0.025, 40
board = np.full((9 * SQUARE_PX, 12 * SQUARE_PX), 255, np.uint8)
for column in range(10):
    for row in range(7):
        if (row + column) % 2:
            board[(row + 1) * SQUARE_PX:(row + 2) * SQUARE_PX, (column + 1) * SQUARE_PX:(column + 2) * SQUARE_PX] = 0

# The ray of every pixel, four to a pixel: where it meets the board is what the pixel shows.
width, height = truth.size_px
x, y = np.meshgrid((np.arange(2 * width) + 0.5) / 2 - 0.5, (np.arange(2 * height) + 0.5) / 2 - 0.5)
rays = truth.unproject(np.column_stack([x.ravel(), y.ravel()]))


def photograph(turn_rad, p_CB, chance):
    """The board's middle at p_CB (m, camera frame), turned by the rotation vector."""
    R = cv2.Rodrigues(np.asarray(turn_rad, float))[0]
    depth = (R[:, 2] @ p_CB) / (rays @ R[:, 2])                       # along each ray to the board's plane
    on_board = (depth[:, None] * rays - p_CB) @ R[:, :2] / SQUARE_M * SQUARE_PX + [6 * SQUARE_PX, 4.5 * SQUARE_PX]
    shape = 2 * height, 2 * width
    fine = cv2.remap(board, *(on_board[:, k].reshape(shape).astype(np.float32) for k in (0, 1)), cv2.INTER_LINEAR,
                     borderValue=110)
    picture = cv2.GaussianBlur(cv2.resize(fine, (width, height), interpolation=cv2.INTER_AREA), (0, 0), 0.6)
    return np.clip(picture + chance.normal(0, 2, picture.shape), 0, 255).astype(np.uint8)


chance = np.random.default_rng(1)
with tempfile.TemporaryDirectory() as folder:
    files = []
    for k in range(16):
        turn = chance.uniform([-0.6, -0.6, -0.3], [0.6, 0.6, 0.3])
        middle = np.array([chance.uniform(-0.16, 0.16), chance.uniform(-0.11, 0.11), chance.uniform(0.3, 0.5)])
        files.append(f"{folder}/board_{k:02}.png")
        cv2.imwrite(files[-1], photograph(turn, middle, chance))

    # One call, as `ballservo calibrate camera` does it: with few pictures, then with all.
    for count in 4, 16:
        done = ballservo.calibrate_camera(files[:count], "chessboard:9x6", SQUARE_M, model="brown")
        sigmas = np.sqrt(np.diag(done.camera.covariance))
        print(f"\n{count} pictures: residual {done.summary['rms_px']:.3f} px; on boards held out "
              f"{done.summary['held_out_rms_px']:.3f} px; a ball at 1 m is moved by "
              f"{done.summary['ball_sigma_mm']:.2f} mm (1 sigma) where that is worst")
        for (name, value), sigma in zip(done.camera.parameters.items(), sigmas):
            wrong = value - truth.parameters[name]
            print(f"  {name:6} {value:10.4f} +- {sigma:8.4f}   truly wrong by {wrong:+9.4f}, {wrong / sigma:+5.1f} sigma")
        for advice in done.summary["advice"]:
            print("  next:", advice)

# Small residuals do not make a good camera: look at the sigmas, and at what held-out boards say.
wrong_px = np.abs(np.array(list(done.camera.parameters.values())[:2]) - 480).max()
if wrong_px > 2:
    sys.exit(f"the focal length should be found to 2 px, not {wrong_px:.2f}")

# Try: all boards parallel to the picture (turn = 0): what becomes of fx_px, and what is the advice?
# Try: model="pinhole". Which figure tells that the lens was forgotten?
# Try: square_m=0.026. Which parameters change, and which do not?
