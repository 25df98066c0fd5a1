"""What lies on the floor, drawn from above: the room, its obstacles, a robot. World frame, metres."""
import numpy as np
from matplotlib.patches import Circle, Polygon, Rectangle

from .page import INK


def draw_room(plot, room):
    x, y = room[:2]
    plot.add_patch(Rectangle((x, y), room[2] - x, room[3] - y, fill=False, edgecolor=INK, linewidth=2))


def draw_obstacles(plot, obstacles):
    """Each has corners (`points_m`), or one centre and a radius."""
    for obstacle in obstacles:
        points = np.reshape(obstacle["points_m"], (-1, 2))
        if len(points) == 0:
            continue
        round_one = obstacle.get("radius_m", 0) > 0
        shape = Circle(points[0], obstacle["radius_m"]) if round_one else Polygon(points)
        shape.set(facecolor=INK, edgecolor=INK, alpha=0.3)
        plot.add_patch(shape)


def draw_robot(plot, footprint, position, yaw_rad, color, dashed=False, arrow=False):
    front, rear, half = footprint["front_m"], -footprint["rear_m"], footprint["half_width_m"]
    turn = np.array([[np.cos(yaw_rad), -np.sin(yaw_rad)], [np.sin(yaw_rad), np.cos(yaw_rad)]])
    corners = np.array([(front, half), (rear, half), (rear, -half), (front, -half)]) @ turn.T + position
    plot.add_patch(Polygon(corners, fill=False, edgecolor=color, linewidth=1, linestyle="--" if dashed else "-"))
    if arrow:
        plot.annotate("", position + turn @ (0.35, 0), position, arrowprops={"arrowstyle": "->", "color": color})
