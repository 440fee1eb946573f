"""The recurrent network: convolutions to one square per 4 x 4 cells, dilated blocks, some of them with memory, and a head."""
from dataclasses import dataclass

import torch
from torch import nn
from torch.nn import functional

from . import surface

FIRST_CHANNELS, RANK = 16, 16
STEP_MS = 5.0  # time in which a gate of 0 forgets half
MOTION = 3  # numbers that tell how the camera moves the image: motion()
MOTION_HIDDEN = 32
OUTPUTS = (
    "log_odds",  # that a ball's centre is in the square
    "x", "y",  # of the centre from the middle of the square, squares
    "log2_radius",  # relative to surface.MEAN_CELLS cells
    "vx", "vy",  # of the centre, squares per 100 ms
    "log_sd_centre", "log_sd_radius",  # of (x, y), squares; of log2_radius
    "inlier_log_odds",  # that the circle is the ball's, within 6 px of its centre and 2 px of its radius
)


@dataclass(frozen=True)
class Shape:
    channels: int = 48
    dilations: tuple = (1, 2, 2, 3)  # of the blocks
    recurrent: tuple = (1, 3)  # blocks with memory

    def multiplications(self, width, height, cells):
        """Of one step on the levels of these cell sizes."""
        c, total = self.channels, 0
        for cell in cells:
            squares = -(-width // (4 * cell)) * -(-height // (4 * cell))
            per_square = 4 * 9 * surface.CHANNELS * FIRST_CHANNELS + 9 * FIRST_CHANNELS + FIRST_CHANNELS * c
            per_square += len(self.dilations) * (9 * c + c**2)
            per_square += len(self.recurrent) * (2 * c * RANK + c**2 + 3 * c) + c * len(OUTPUTS)
            total += squares * per_square
        return total


def shifted(state, shift):
    """Moves the states of the squares (batch x rows x columns x channels) by whole squares (batch x 2: x, y); what comes in is 0."""
    batch, rows, columns, channels = state.shape
    x = torch.arange(columns, device=state.device) - shift[:, :1]
    y = torch.arange(rows, device=state.device) - shift[:, 1:]
    inside = ((y >= 0) & (y < rows))[:, :, None] & ((x >= 0) & (x < columns))[:, None]
    number = torch.arange(batch, device=state.device)[:, None, None]
    place = (number * rows + y.clamp(0, rows - 1)[:, :, None]) * columns + x.clamp(0, columns - 1)[:, None]
    return state.reshape(-1, channels)[place.flatten()].view_as(state) * inside[..., None]


def motion(squares_per_100_ms, known):
    """What the network is told of the image's motion by the camera's rotation: ... x 2 -> ... x MOTION."""
    v = squares_per_100_ms * known
    return torch.cat([v.sign() * v.abs().log1p(), torch.ones_like(v[..., :1]) * known], -1).float()


def depthwise(layer, x):
    """A depthwise convolution. On CUDA as a dense one with zeros, which is much faster with its gradients."""
    if not x.is_cuda:
        return layer(x)
    dense = layer.weight * torch.eye(layer.out_channels, device=x.device)[:, :, None, None]
    return functional.conv2d(x, dense, None, layer.stride, layer.padding, layer.dilation)


class Memory(nn.Module):
    """h <- a h + (1 - a) u, a = exp(-softplus(gate) dt / STEP_MS); the gate comes from the present input alone, so all steps
    of a sequence are computed at once but for this line."""

    def __init__(self, channels):
        super().__init__()
        self.down, self.up = nn.Conv2d(channels, RANK, 1, bias=False), nn.Conv2d(RANK, channels, 1)
        self.out = nn.Conv2d(channels, channels, 1, bias=False)
        nn.init.zeros_(self.out.weight)
        # Half-lives of 10 to 300 ms at first.
        nn.init.normal_(self.up.weight, std=0.1)
        half_lives = 10.0 * 30.0 ** (torch.arange(channels) / (channels - 1))
        rate = 0.6931 * STEP_MS / half_lives
        self.up.bias.data[:] = torch.log(torch.expm1(rate))

    def forward(self, x, u, dt_ms, state, shift):
        """x, u: batch * time x channels x rows x columns; dt_ms: batch; state: batch x rows x columns x channels; shift: batch x
        time x 2, squares that the camera has moved the image by since the last step."""
        batch = len(dt_ms)
        rate = functional.softplus(self.up(self.down(x))) * (dt_ms / STEP_MS).repeat_interleave(len(x) // batch)[:, None, None, None]
        a = torch.exp(-rate).permute(0, 2, 3, 1).unflatten(0, (batch, -1))
        new = u.permute(0, 2, 3, 1).unflatten(0, (batch, -1)) * (1 - a)
        states = []
        moves = shift.any(2).any(0).tolist()
        for t, (factor, added) in enumerate(zip(a.unbind(1), new.unbind(1))):
            if moves[t]:
                state = shifted(state, shift[:, t])
            state = torch.addcmul(added, factor, state)
            states.append(state)
        remembered = torch.stack(states, 1).flatten(0, 1).permute(0, 3, 1, 2)
        return self.out(remembered), state


class Network(nn.Module):
    def __init__(self, shape=Shape()):
        super().__init__()
        self.shape, self.layout = shape, torch.channels_last
        channels, blocks = shape.channels, len(shape.dilations)
        self.first = nn.Conv2d(surface.CHANNELS, FIRST_CHANNELS, 3, stride=2, padding=1)
        self.second_depth = nn.Conv2d(
            FIRST_CHANNELS, FIRST_CHANNELS, 3, stride=2, padding=1, groups=FIRST_CHANNELS, bias=False)
        self.second_point = nn.Conv2d(FIRST_CHANNELS, channels, 1)
        self.depth = nn.ModuleList(
            nn.Conv2d(channels, channels, 3, padding=d, dilation=d, groups=channels, bias=False) for d in shape.dilations)
        self.point = nn.ModuleList(nn.Conv2d(channels, channels, 1) for _ in shape.dilations)
        self.memory = nn.ModuleList(Memory(channels) for _ in shape.recurrent)
        self.motion = nn.Sequential(
            nn.Linear(MOTION, MOTION_HIDDEN), nn.ReLU(), nn.Linear(MOTION_HIDDEN, (1 + blocks) * channels, bias=False))
        nn.init.zeros_(self.motion[2].weight)
        self.output = nn.Conv2d(channels, len(OUTPUTS), 1)
        nn.init.zeros_(self.output.weight[4:])
        nn.init.zeros_(self.output.bias)
        self.output.bias.data[0] = -4.0
        self.output.bias.data[6:8] = -1.0

    def start(self, batch, rows, columns):
        """The state before the first step; rows and columns in squares."""
        return [torch.zeros(batch, rows, columns, self.shape.channels, device=self.output.weight.device) for _ in self.shape.recurrent]

    def forward(self, x, dt_ms, state, shift, motion):
        """x: batch x time x channels x rows x columns of cells, multiples of surface.SQUARE; dt_ms: batch, time between steps;
        shift: batch x time x 2, whole squares that the camera's rotation has moved the image by since the step before;
        motion: batch x time x MOTION.
        Returns batch x time x outputs x rows x columns of squares, and the state after the last step."""
        batch = len(x)
        x = x.flatten(0, 1).contiguous(memory_format=self.layout)
        x = functional.relu(self.first(x))
        bias = self.motion(motion.flatten(0, 1))[:, :, None, None].chunk(1 + len(self.shape.dilations), 1)
        x = functional.relu(self.second_point(depthwise(self.second_depth, x)) + bias[0])
        state = list(state)
        for n, (depth, point) in enumerate(zip(self.depth, self.point)):
            u = depthwise(depth, x)
            add = point(u)
            if n in self.shape.recurrent:
                k = self.shape.recurrent.index(n)
                remembered, state[k] = self.memory[k](x, u, dt_ms, state[k], shift)
                add = add + remembered
            x = functional.relu(x + add + bias[1 + n])
        return self.output(x).unflatten(0, (batch, -1)), state


def load_weights(network, arrays):
    """Exported weights, or those of the network without memory (models/recurrent/start.npz): the same outputs as it at first."""
    own = network.state_dict()
    whole = len(arrays["output.bias"]) == len(OUTPUTS)
    for name, values in arrays.items():
        own[name][: len(values)] = torch.from_numpy(values)
    for name in () if whole else ("output.weight", "output.bias"):  # the inlier's log odds start as those of the centre
        own[name][8] = own[name][0]
    network.load_state_dict(own)
