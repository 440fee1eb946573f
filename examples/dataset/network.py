"""A small network: for each of 16 x 16 squares whether a ball's centre is in it, and where and how large the ball is."""
import torch
from torch import nn

from surfaces import CELLS, CHANNELS

SQUARES = 16
STRIDE = CELLS // SQUARES


class Block(nn.Module):
    def __init__(self, width, dilation):
        super().__init__()
        self.convolution = nn.Conv2d(width, width, 3, padding=dilation, dilation=dilation)
        self.norm = nn.BatchNorm2d(width)

    def forward(self, x):
        return x + torch.relu(self.norm(self.convolution(x)))


class Network(nn.Module):
    def __init__(self, width=32):
        super().__init__()
        self.layers = nn.Sequential(
            nn.Conv2d(CHANNELS, width // 2, 5, stride=2, padding=2), nn.ReLU(),
            nn.Conv2d(width // 2, width, 3, stride=2, padding=1), nn.BatchNorm2d(width), nn.ReLU(),
            *(Block(width, dilation) for dilation in (1, 2, 3, 1)), nn.Conv2d(width, 4, 1))

    def forward(self, surfaces):
        """surfaces: uint8 (N, CHANNELS, CELLS, CELLS). Returns (N, 4, SQUARES, SQUARES): log odds of a centre, its place in the
        square (0 to 1) and the logarithm of the radius, in cells."""
        return self.layers(surfaces.float() / 255)


def circles(output):
    """The best circle of each image, in cells: (N, 4) of x, y, r and score."""
    best = output[:, 0].flatten(1).argmax(1)
    at = output.flatten(2).gather(2, best[:, None, None].expand(-1, 4, 1))[..., 0]
    x = (best % SQUARES + at[:, 1]) * STRIDE
    y = (best // SQUARES + at[:, 2]) * STRIDE
    return torch.stack([x, y, at[:, 3].exp(), at[:, 0].sigmoid()], 1)
