#pragma once

#include <filesystem>
#include <string>

namespace saccade {

class FormatRegistry;

/// Writes `report.html` and the numbers of its figures, `figures/NAME.csv`, into a run folder from the files in
/// it: metrics.json (needed), truth.csv, detections.csv, gaze.csv, eye.csv, the events, and the images that
/// the run saved as `frames/<t_us>_eye.png` (grey, of the camera's size), `frames/<t_us>_scene.png` (colour,
/// third person) and `frames/<t_us>_<detector>_hough_<max>.png` (grey, of the camera's size, 255 standing for
/// `max`). Sections without data are left out. Without saved images the page shows the events alone at instants spread
/// over the run. `formats`: of the event file. The page needs no other file and no network.
/// `figures`: each figure is also written there at the size of a paper (FigureFolder::paper); empty: not. Throws InputError for a folder without a readable
/// metrics.json or with a broken table; RunError when a figure cannot be drawn or the page cannot be written. Without
/// gnuplot the page has no drawn figures, and says so; undrawn_warning() is the line for the terminal.
void write_report(const std::filesystem::path& run_folder, const FormatRegistry& formats,
                  const std::filesystem::path& figures = {});

/// That the figures of pages are not drawn because gnuplot is missing; empty where it is installed.
[[nodiscard]] std::string undrawn_warning();

}  // namespace saccade
