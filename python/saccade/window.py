"""A window that shows images: render_mode "human" of Env."""

import time


class Window:
    """Shows RGB images, at most 30 a second of the wall clock."""

    def __init__(self, title):
        try:
            import tkinter
        except ImportError as error:
            raise RuntimeError("render_mode: human needs tkinter (Debian package python3-tk)") from error
        try:
            self._root = tkinter.Tk()
        except tkinter.TclError as error:
            raise RuntimeError(f"render_mode: human needs a display: {error}") from error
        self._root.title(title)
        self._photo = None
        self._photo_type = tkinter.PhotoImage
        self._label = tkinter.Label(self._root)
        self._label.pack()
        self._root.protocol("WM_DELETE_WINDOW", self.close)
        self._shown_s = 0.0

    def is_due(self):
        return self._root is not None and time.monotonic() - self._shown_s >= 1 / 30

    def show(self, rgb):
        if self._root is None:
            return
        self._shown_s = time.monotonic()
        height, width, _ = rgb.shape
        self._photo = self._photo_type(data=b"P6 %d %d 255 " % (width, height) + rgb.tobytes(), format="PPM")
        self._label.configure(image=self._photo)
        self._root.update()

    def close(self):
        root, self._root = self._root, None
        if root is not None:
            root.destroy()
