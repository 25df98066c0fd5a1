"""ballservo: a robot sees a coloured ball, places it in 3-D and drives to it."""
