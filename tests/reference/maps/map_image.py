"""Slow, obvious twins of the rules from pixels to occupancy: one pixel after the other, as in the upstream loops."""

import math

import numpy as np


def map_server(channels, mode, negate, occupied_thresh, free_thresh):
    """``image_loader.cpp`` of map_server, for (height, width, 1, 3 or 4) pixels; raw values over 100 are unknown."""
    height, width, count = channels.shape
    cells = np.empty((height, width), np.int8)
    for row in range(height):
        for column in range(width):
            pixel = channels[row, column].tolist()
            averaged = pixel[:3] if count == 4 and mode != "trinary" else pixel
            mean = sum(averaged) / len(averaged)
            alpha = pixel[3] if count == 4 else 1
            if negate:
                mean = 255 - mean
            occupied = (255 - mean) / 255.0
            if mode == "raw":
                value = int(mean) if int(mean) <= 100 else -1
            elif occupied > occupied_thresh:
                value = 100
            elif occupied < free_thresh:
                value = 0
            elif mode == "trinary" or alpha < 1.0 or occupied_thresh == free_thresh:  # 0 / 0 in map_server
                value = -1
            else:
                value = int(1 + 98 * ((occupied - free_thresh) / (occupied_thresh - free_thresh)))
            cells[row, column] = value
    return cells


def nav2(channels, mode, negate, occupied_thresh, free_thresh):
    """``map_io.cpp`` of Nav2, for the same pixels."""
    height, width, count = channels.shape
    low, high = np.float32(free_thresh), np.float32(occupied_thresh)
    cells = np.empty((height, width), np.int8)
    for row in range(height):
        for column in range(width):
            pixel = channels[row, column].tolist()
            grey = pixel[0] if count == 1 else round_half_up((299 * pixel[0] + 587 * pixel[1] + 114 * pixel[2]) / 1000)
            shade = np.float32(grey) / np.float32(255)
            occupied = shade if negate else np.float32(1) - shade
            if mode == "raw":
                value = grey if grey <= 100 else -1
            elif count == 4 and pixel[3] < 255:
                value = -1
            elif occupied <= low:
                value = 0
            elif occupied >= high:
                value = 100
            elif mode == "trinary":
                value = -1
            else:
                value = round_half_up(float((occupied - low) / (high - low) * np.float32(100)))
            cells[row, column] = value
    return cells


def round_half_up(number: float) -> int:
    """Return the nearest whole number of a number that is not negative, as C's ``round`` does."""
    return math.floor(number + 0.5)
