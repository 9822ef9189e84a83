"""Real mouse and keys for a script that runs inside a Blender window, and looks at the screen.

The script is a generator: it yields the seconds that Blender is given before it goes on. Events
go through the X server (xdotool), pictures come from it (ImageMagick's import).
"""

from __future__ import annotations

import os
import subprocess
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path

import bpy
import numpy as np

# Seconds between two looks of a scenario at the window.
_TICK = 0.05
# Turns of Blender's main loop in which all that the hand has done is handled and drawn: press and
# release, what they open, and its redrawing, with as many again to spare; and those between two
# movements, for Blender acts on what it has drawn under the mouse.
_TURNS, _BETWEEN = 8, 3
# Seconds after which what is waited for will not come, however busy the machine is.
PATIENCE = 300.0
# What the process ends with if the hand was not heard; conftest.py then plays once more.
LOST = 3


class LostEventError(Exception):
    """The mouse or a key had no effect at several tries: a busy virtual screen loses events."""


def play(scenario: Callable[[], Iterator[float]], first: float = 1.5, smooth: bool = False) -> None:
    """Run the scenario as soon as the window stands, then close Blender.

    `smooth` has views drawn as Blender draws them by default, in eight samples. Each of these is a
    drawing of its own, which takes most of a scenario's time where there is no graphics card.
    """
    bpy.context.preferences.view.show_splash = False
    draw_smoothly(smooth)
    # A view that glides to its new place would be looked at, or moved again, on its way.
    bpy.context.preferences.view.smooth_view = 0
    # On a busy machine the second click of two comes late.
    bpy.context.preferences.inputs.mouse_double_click_time = 1000
    # Blender's jumps of the mouse, which let a drag go on past the edge, are not followed here.
    bpy.context.preferences.inputs.use_mouse_continuous = False
    steps = scenario()
    wanted = 0.0
    turns, since = 0, time.monotonic()

    # Without a window manager nobody gives the window the keys.
    bpy.app.timers.register(_take_keyboard, first_interval=0.5 * first)

    def step() -> float | None:
        """Give Blender the seconds that the scenario wants once the hand is at rest, and as many
        turns as it needs to act on what the hand did: on a busy machine these take longer."""
        nonlocal wanted, turns, since
        try:
            if _moving() or (_movements and turns >= _BETWEEN and _move()):
                turns, since = 0, time.monotonic()
                return _TICK
            turns += 1
            left = since + wanted - time.monotonic()
            if _movements or left > 1e-9 or turns < min(_TURNS, round(wanted / _TICK)):
                return _TICK if _movements else min(max(left, 0.0), _TICK)
            wanted = next(steps)
            turns, since = 0, time.monotonic()
            return min(wanted, _TICK)
        except StopIteration:
            os._exit(0)
        except LostEventError:
            traceback.print_exc()
            os._exit(LOST)
        except BaseException:  # noqa: BLE001 (whatever it is, Blender has to end)
            traceback.print_exc()
            os._exit(1)

    bpy.app.timers.register(step, first_interval=first, persistent=True)


def draw_smoothly(smooth: bool) -> None:
    """Draw views in Blender's usual number of samples, or in one."""
    bpy.context.preferences.system.viewport_aa = "8" if smooth else "OFF"


class View:
    """The largest 3D view of a window, looked up anew after every load and undo."""

    def __init__(self, window: int = 0) -> None:
        self._window = window

    @property
    def window(self) -> bpy.types.Window:
        return bpy.context.window_manager.windows[self._window]

    @property
    def area(self) -> bpy.types.Area:
        views = [area for area in self.window.screen.areas if area.type == "VIEW_3D"]
        return max(views, key=lambda area: area.width * area.height)

    def region(self, kind: str) -> bpy.types.Region:
        return next(region for region in self.area.regions if region.type == kind)

    @property
    def space(self) -> bpy.types.SpaceView3D:
        return self.area.spaces.active

    def inside(self):
        """A context as if the mouse were in the view."""
        return bpy.context.temp_override(
            window=self.window, area=self.area, region=self.region("WINDOW")
        )

    def middle(self) -> tuple[int, int]:
        """Screen pixels of the middle of what the sidebar leaves free."""
        region = self.region("WINDOW")
        sidebar = self.region("UI")
        free = region.width - (sidebar.width if self.space.show_region_ui else 0)
        return region.x + free // 2, self.window.height - region.y - region.height // 2

    def in_sidebar(self, x: float, y: float) -> tuple[int, int]:
        """Screen pixels of a place in the sidebar, from its left (0) to its right (1) and in
        pixels below its top."""
        region = self.region("UI")
        top = self.window.height - region.y - region.height
        return round(region.x + x * (region.width - 20)), round(top + y)


def point(x: int, y: int) -> None:
    _xdotool("mousemove", x, y)


def click(x: int, y: int, count: int = 1, button: int = 1) -> None:
    point(x - 3, y)
    point(x, y)
    _xdotool(*["mousedown", button, "sleep", 0.05, "mouseup", button, "sleep", 0.08] * count)


def until(done: Callable[[], bool], limit: float = PATIENCE) -> Iterator[float]:
    """Wait for something, and then for all that comes with it; no longer than `limit` seconds."""
    end = time.monotonic() + limit
    while not done() and time.monotonic() < end:
        yield _TICK
    yield _TURNS * _TICK


def insist(done: Callable[[], bool], place: tuple[int, int], count: int = 1) -> Iterator[float]:
    """Click until it has the wanted effect.

    Raises LostEventError if it never has.
    """

    def clicked() -> Iterator[float]:
        click(*place, count=count)
        yield _TURNS * _TICK

    yield from _repeat(clicked, done)


def _repeat(act: Callable[[], Iterator[float]], done: Callable[[], bool]) -> Iterator[float]:
    for _ in range(4):
        yield from act()
        yield from until(done, 1.4)
        if done():
            return
    raise LostEventError


def drag(start: tuple[int, int], end: tuple[int, int], steps: int = 12) -> Iterator[float]:
    """Press, move and let go, giving Blender time to follow."""
    point(*start)
    _xdotool("mousedown", 1)
    for step in range(1, steps + 1):
        part = step / steps
        point(*(round(a + (b - a) * part) for a, b in zip(start, end, strict=True)))
    _xdotool("mouseup", 1)
    yield _TURNS * _TICK


def insist_on_drag(
    done: Callable[[], bool], start: tuple[int, int], end: tuple[int, int]
) -> Iterator[float]:
    """Drag until it has the wanted effect, as `insist` clicks.

    `done` has to hold as soon as the drag is noticed: a second one would go further.
    """
    yield from _repeat(lambda: drag(start, end), done)


def insist_on_value(
    done: Callable[[], bool], place: tuple[int, int], value: float
) -> Iterator[float]:
    """Type a number into the field there, as `insist` clicks; Return opens the field."""

    def typed() -> Iterator[float]:
        point(place[0] - 3, place[1])
        point(*place)
        for key in ("Return", "ctrl+a"):
            press(key)
            yield _TURNS * _TICK
        write(f"{value:.4f}")
        press("Return")
        yield _TURNS * _TICK

    yield from _repeat(typed, done)


def press(*keys: str) -> None:
    _xdotool("key", *keys)


def write(text: str) -> None:
    """Type a text."""
    _xdotool("type", "--delay", 60, text)


def place_in(window: bpy.types.Window, x: int, y: int) -> tuple[int, int]:
    """Screen pixels of a place in a window, from its left and its top."""
    height = int(os.environ.get("UMBILICS_SCREEN_HEIGHT", "900"))
    return window.x + x, height - window.y - window.height + y


def move_window(name: str, x: int, y: int) -> None:
    """Put a window of that name elsewhere: nobody else manages windows here."""
    _xdotool("search", "--sync", "--onlyvisible", "--name", name, "windowmove", x, y)


def arrange_windows(width: int = 1600, height: int = 900) -> None:
    """Put all windows of Blender beside each other, on a screen of this size."""
    names = subprocess.run(
        ["xdotool", "search", "--onlyvisible", "--class", "Blender"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    part = width // len(names)
    for place, name in enumerate(names):
        _xdotool("windowsize", name, part, height, "windowmove", name, place * part, 0)


def focus(name: str) -> None:
    """Give the keys to a window of that name, and put it on top."""
    _xdotool("search", "--sync", "--onlyvisible", "--name", name, "windowraise", "windowfocus")


def picture(path: Path) -> None:
    """The whole screen as a PNG file."""
    assert not _movements and not _moving(), "yield first, so that the hand comes to rest"
    path.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run(["import", "-window", "root", str(path)], check=True)


def pixels(path: Path) -> np.ndarray:
    """(height, width, 3) a picture, rows from the top."""
    image = bpy.data.images.load(str(path))
    try:
        width, height = image.size
        found = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(found)
    finally:
        bpy.data.images.remove(image)
    return found.reshape(height, width, -1)[::-1, :, :3]


def open_tab(view: View, name: str = "Umbilics") -> Iterator[float]:
    """Show the sidebar's tab by clicking down its tabs until it is there."""
    view.space.show_region_ui = True
    yield 0.5
    region = view.region("UI")
    if region.active_panel_category == name:
        # A click on the tab that is open would close the sidebar.
        return
    # Add-ons come last.
    for y in sorted(range(20, 420, 22), key=lambda y: abs(y - 240)):
        click(*(view.in_sidebar(1.0, y)[0] + 10, view.in_sidebar(1.0, y)[1]))
        yield _TURNS * _TICK
        if region.active_panel_category == name:
            # A first key and a rest in the view, or the next click does nothing.
            point(*view.middle())
            press("Escape")
            yield _TURNS * _TICK
            return
    raise LostEventError(f"there is no tab {name}")


def file_browsers() -> list[tuple[bpy.types.Window, bpy.types.Area]]:
    """The file browsers that are open, each with its window."""
    return [
        (window, area)
        for window in bpy.context.window_manager.windows
        for area in window.screen.areas
        if area.type == "FILE_BROWSER"
    ]


def choose_file(path: Path) -> Iterator[float]:
    """Find a file in the file browser that has opened, and confirm it."""
    yield from until(lambda: bool(file_browsers()))
    move_window("Blender File View", 240, 130)
    focus("Blender File View")
    yield 1.0
    window, files = file_browsers()[0]
    regions = {region.type: region for region in files.regions}
    folders, confirm = regions["UI"], regions["EXECUTE"]
    # The folder's field takes a whole path.
    click(*_inside(window, folders, 0.3, 0.5))
    yield 1.0
    press("ctrl+a")
    yield 0.3
    write(str(path))
    yield 0.5
    press("Return")
    yield 1.0
    # The first click ends the typing.
    for _ in range(4):
        click(*_inside(window, confirm, 0.92, 0.5))
        yield from until(lambda: not file_browsers(), 2.0)
        if not file_browsers():
            return
    raise LostEventError(f"{path} was not taken")


def _inside(
    window: bpy.types.Window, region: bpy.types.Region, x: float, y: float
) -> tuple[int, int]:
    """Screen pixels of a place in a region, in parts of its width and height from its top."""
    top = window.height - region.y - region.height
    return place_in(window, round(region.x + x * region.width), round(top + y * region.height))


def _take_keyboard() -> None:
    _xdotool("search", "--sync", "--onlyvisible", "--class", "Blender", "windowfocus")


# What the hand is at, and what it is to do then: Blender has to go on meanwhile, or it sees all
# events at once.
_hand: subprocess.Popen | None = None
_movements: deque[tuple[str, ...]] = deque()


def _xdotool(*arguments) -> None:
    _movements.append(tuple(map(str, arguments)))


def _moving() -> bool:
    """Whether the hand is at something."""
    if _hand is None or _hand.poll() is None:
        return _hand is not None
    if _hand.returncode:
        raise AssertionError(f"xdotool failed: {_hand.args}")
    return False


def _move() -> bool:
    """Begin the next movement."""
    global _hand  # noqa: PLW0603
    _hand = subprocess.Popen(["xdotool", *_movements.popleft()])
    return True
