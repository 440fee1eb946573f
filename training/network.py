"""The recurrent network: convolutions to one square per 4 x 4 cells, dilated blocks, two of them with memory, and a head."""
import numpy as np
import torch
from torch import nn
from torch.nn import functional

from . import surface

FIRST_CHANNELS, CHANNELS, RANK = 16, 48, 16
DILATIONS = (1, 2, 2, 3)
RECURRENT = (1, 3)  # blocks with memory
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


def shifted(state, shift):
    """Moves each map of a batch by whole squares (x, y); what comes in is 0."""
    limit = (state.shape[3], state.shape[2])
    maps = []
    for one, (x, y) in zip(state.split(1), shift.tolist()):
        x, y = max(-limit[0], min(limit[0], x)), max(-limit[1], min(limit[1], y))
        maps.append(functional.pad(one, (x, -x, y, -y)) if x or y else one)
    return torch.cat(maps)


def motion(squares_per_100_ms, known):
    """What the network is told of the image's motion by the camera's rotation: ... x 2 -> ... x MOTION."""
    v = squares_per_100_ms * known
    return np.concatenate([np.sign(v) * np.log1p(abs(v)), np.full((*v.shape[:-1], 1), known)], -1).astype(np.float32)


class Memory(nn.Module):
    """h <- a h + (1 - a) u, a = exp(-softplus(gate) dt / STEP_MS); the gate comes from the present input alone, so all steps
    of a sequence are computed at once but for this line."""

    def __init__(self):
        super().__init__()
        self.down, self.up = nn.Conv2d(CHANNELS, RANK, 1, bias=False), nn.Conv2d(RANK, CHANNELS, 1)
        self.out = nn.Conv2d(CHANNELS, CHANNELS, 1, bias=False)
        nn.init.zeros_(self.out.weight)
        # Half-lives of 10 to 300 ms at first.
        nn.init.normal_(self.up.weight, std=0.1)
        half_lives = 10.0 * 30.0 ** (torch.arange(CHANNELS) / (CHANNELS - 1))
        rate = 0.6931 * STEP_MS / half_lives
        self.up.bias.data[:] = torch.log(torch.expm1(rate))

    def forward(self, x, u, dt_ms, state, shift):
        """x, u: batch * time x channels x rows x columns; dt_ms: batch; state: batch x channels x rows x columns; shift: batch x
        time x 2, squares that the camera has moved the image by since the last step."""
        batch = len(dt_ms)
        rate = functional.softplus(self.up(self.down(x))) * (dt_ms / STEP_MS).repeat_interleave(len(x) // batch)[:, None, None, None]
        a = torch.exp(-rate).unflatten(0, (batch, -1))
        new = u.unflatten(0, (batch, -1)) * (1 - a)
        states = []
        moves = shift.any(2).any(0).tolist()
        for t, (factor, added) in enumerate(zip(a.unbind(1), new.unbind(1))):
            if moves[t]:
                state = shifted(state, shift[:, t])
            state = torch.addcmul(added, factor, state)
            states.append(state)
        remembered = torch.stack(states, 1).flatten(0, 1).contiguous(memory_format=torch.channels_last)
        return self.out(remembered), state


class Network(nn.Module):
    def __init__(self):
        super().__init__()
        self.first = nn.Conv2d(surface.CHANNELS, FIRST_CHANNELS, 3, stride=2, padding=1)
        self.second_depth = nn.Conv2d(
            FIRST_CHANNELS, FIRST_CHANNELS, 3, stride=2, padding=1, groups=FIRST_CHANNELS, bias=False)
        self.second_point = nn.Conv2d(FIRST_CHANNELS, CHANNELS, 1)
        self.depth = nn.ModuleList(
            nn.Conv2d(CHANNELS, CHANNELS, 3, padding=d, dilation=d, groups=CHANNELS, bias=False) for d in DILATIONS)
        self.point = nn.ModuleList(nn.Conv2d(CHANNELS, CHANNELS, 1) for _ in DILATIONS)
        self.memory = nn.ModuleList(Memory() for _ in RECURRENT)
        self.motion = nn.Sequential(
            nn.Linear(MOTION, MOTION_HIDDEN), nn.ReLU(), nn.Linear(MOTION_HIDDEN, (1 + len(DILATIONS)) * CHANNELS, bias=False))
        nn.init.zeros_(self.motion[2].weight)
        self.output = nn.Conv2d(CHANNELS, len(OUTPUTS), 1)
        nn.init.zeros_(self.output.weight[4:])
        nn.init.zeros_(self.output.bias)
        self.output.bias.data[0] = -4.0
        self.output.bias.data[6:8] = -1.0

    def start(self, batch, rows, columns):
        """The state before the first step; rows and columns in squares."""
        return [torch.zeros(batch, CHANNELS, rows, columns) for _ in RECURRENT]

    def forward(self, x, dt_ms, state, shift, motion):
        """x: batch x time x channels x rows x columns of cells, multiples of surface.SQUARE; dt_ms: batch, time between steps;
        shift: batch x time x 2, whole squares that the camera's rotation has moved the image by since the step before;
        motion: batch x time x MOTION.
        Returns batch x time x outputs x rows x columns of squares, and the state after the last step."""
        batch = len(x)
        x = x.flatten(0, 1).contiguous(memory_format=torch.channels_last)  # twice as fast
        x = functional.relu(self.first(x))
        bias = self.motion(motion.flatten(0, 1))[:, :, None, None].chunk(1 + len(DILATIONS), 1)
        x = functional.relu(self.second_point(self.second_depth(x)) + bias[0])
        state = list(state)
        for n, (depth, point) in enumerate(zip(self.depth, self.point)):
            u = depth(x)
            add = point(u)
            if n in RECURRENT:
                k = RECURRENT.index(n)
                remembered, state[k] = self.memory[k](x, u, dt_ms, state[k], shift)
                add = add + remembered
            x = functional.relu(x + add + bias[1 + n])
        return self.output(x).unflatten(0, (batch, -1)), state


def multiplications(width, height, cells):
    """Of one step on the levels of these cell sizes."""
    total = 0
    for cell in cells:
        squares = -(-width // (4 * cell)) * -(-height // (4 * cell))
        per_square = 4 * 9 * surface.CHANNELS * FIRST_CHANNELS + 9 * FIRST_CHANNELS + FIRST_CHANNELS * CHANNELS
        per_square += len(DILATIONS) * (9 * CHANNELS + CHANNELS**2)
        per_square += len(RECURRENT) * (2 * CHANNELS * RANK + CHANNELS**2 + 3 * CHANNELS) + CHANNELS * len(OUTPUTS)
        total += squares * per_square
    return total


def load_start(network, arrays):
    """Weights of the network without memory (models/recurrent/start.npz): the same outputs as it at first."""
    own = network.state_dict()
    for name, values in arrays.items():
        if name.startswith("output"):
            own[name][: len(values)] = torch.from_numpy(values)
        else:
            own[name][:] = torch.from_numpy(values)
    for name in ("output.weight", "output.bias"):  # the inlier's log odds start as those of the centre
        own[name][8] = own[name][0]
    network.load_state_dict(own)


def load_weights(network, arrays):
    """Exported weights, or those without memory."""
    if len(arrays["output.bias"]) < len(OUTPUTS):
        load_start(network, arrays)
    else:
        network.load_state_dict(network.state_dict() | {name: torch.from_numpy(values) for name, values in arrays.items()})
