#!/usr/bin/python3
"""Reads what `ballservo track ... --stream` sends and says where the balls are.

    ballservo track camera:0 --colors my.colors --stream - | python3 app/examples/read_stream.py
    python3 app/examples/read_stream.py 9000 &           # for --stream udp:127.0.0.1:9000
"""
import json
import socket
import sys


def lines():
    if len(sys.argv) < 2:
        yield from sys.stdin
        return
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    receiver.bind(("127.0.0.1", int(sys.argv[1])))
    while True:
        yield receiver.recv(65535).decode()


for line in lines():
    picture = json.loads(line)
    for ball in picture["balls"]:
        if ball["p_m"] is None:  # --camera and --diameter give metres
            where = "at {:.1f}, {:.1f} px".format(*ball["outline_px"])
        else:
            sigmas_m = [ball["covariance_m2"][i][i] ** 0.5 for i in range(3)]
            where = "at " + ", ".join("{:.3f} +- {:.3f}".format(*axis) for axis in zip(ball["p_m"], sigmas_m)) + " m"
        print(f"{picture['time_s']:.3f} s: {ball['class']} {ball['track_id']} ({ball['state']}) {where}", flush=True)
