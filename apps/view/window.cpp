#include "apps/view/window.h"

#define GLFW_INCLUDE_GLEXT
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <dlfcn.h>
#include <imgui.h>

#include <cstdlib>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "core/error.h"

namespace saccade {
namespace {

const char* const no_display =
    "an X display to show the window on; on a machine without a screen: xvfb-run -s '-screen 0 1280x720x24' "
    "saccade ...";

ImVec4 grey(float level, float alpha = 1.0F) { return {level, level, level * 1.06F, alpha}; }

void set_style() {
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 5.0F;
  style.FrameRounding = 3.0F;
  style.GrabRounding = 3.0F;
  style.WindowBorderSize = 0.0F;
  style.WindowPadding = {8.0F, 5.0F};
  style.FramePadding = {6.0F, 3.0F};
  style.ItemSpacing = {6.0F, 5.0F};
  style.ScrollbarSize = 10.0F;
  style.Colors[ImGuiCol_WindowBg] = grey(0.125F);
  style.Colors[ImGuiCol_PopupBg] = grey(0.16F);
  style.Colors[ImGuiCol_FrameBg] = grey(0.2F);
  style.Colors[ImGuiCol_FrameBgHovered] = grey(0.26F);
  style.Colors[ImGuiCol_FrameBgActive] = grey(0.3F);
  style.Colors[ImGuiCol_Button] = grey(0.23F);
  style.Colors[ImGuiCol_ButtonHovered] = grey(0.31F);
  style.Colors[ImGuiCol_ButtonActive] = grey(0.38F);
  style.Colors[ImGuiCol_Header] = grey(0.22F);
  style.Colors[ImGuiCol_HeaderHovered] = grey(0.3F);
  style.Colors[ImGuiCol_HeaderActive] = grey(0.34F);
  style.Colors[ImGuiCol_SliderGrab] = {0.36F, 0.61F, 0.84F, 1.0F};
  style.Colors[ImGuiCol_SliderGrabActive] = {0.5F, 0.74F, 0.95F, 1.0F};
  style.Colors[ImGuiCol_CheckMark] = {0.5F, 0.74F, 0.95F, 1.0F};
  style.Colors[ImGuiCol_Text] = grey(0.88F);
  style.Colors[ImGuiCol_TextDisabled] = grey(0.56F);
}

}  // namespace

struct Window::Functions {
  explicit Functions(const Window& window) {
    const auto load = [&](auto& pointer, const char* name) {
      pointer = reinterpret_cast<std::remove_reference_t<decltype(pointer)>>(window.function(name));
      if (pointer == nullptr) throw RunError(std::string("OpenGL failed: no ") + name);
    };
    load(viewport, "glViewport");
    load(clear_color, "glClearColor");
    load(clear, "glClear");
    load(read_pixels, "glReadPixels");
    load(pixel_store, "glPixelStorei");
    load(gen_textures, "glGenTextures");
    load(delete_textures, "glDeleteTextures");
    load(bind_texture, "glBindTexture");
    load(tex_parameter, "glTexParameteri");
    load(tex_image, "glTexImage2D");
    load(tex_sub_image, "glTexSubImage2D");
    load(bind_framebuffer, "glBindFramebuffer");
    load(disable, "glDisable");
  }
  decltype(&glViewport) viewport;
  decltype(&glClearColor) clear_color;
  decltype(&glClear) clear;
  decltype(&glReadPixels) read_pixels;
  decltype(&glPixelStorei) pixel_store;
  decltype(&glGenTextures) gen_textures;
  decltype(&glDeleteTextures) delete_textures;
  decltype(&glBindTexture) bind_texture;
  decltype(&glTexParameteri) tex_parameter;
  decltype(&glTexImage2D) tex_image;
  decltype(&glTexSubImage2D) tex_sub_image;
  PFNGLBINDFRAMEBUFFERPROC bind_framebuffer;
  decltype(&glDisable) disable;
};

Window::Window(const std::string& title, int width, int height) {
  const char* display = std::getenv("DISPLAY");
  const std::string found = display == nullptr || *display == '\0' ? "not set" : display;
  if (glfwInit() != GLFW_TRUE) throw InputError("DISPLAY", found, no_display);
  // The window itself is drawn without depth, stencil and alpha.
  for (const int bits : {GLFW_DEPTH_BITS, GLFW_STENCIL_BITS, GLFW_ALPHA_BITS}) glfwWindowHint(bits, 0);
  window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (window_ == nullptr) {
    const char* why = nullptr;
    glfwGetError(&why);
    const std::string text = why == nullptr ? "no window" : why;
    glfwTerminate();
    throw RunError("no window: " + text);
  }
  glfwSetWindowSizeLimits(window_, 1024, 640, GLFW_DONT_CARE, GLFW_DONT_CARE);
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(0);
  identify("window");
  gl_ = std::make_unique<Functions>(*this);
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // the places of the panels are set each time
  io.ConfigFlags |= ImGuiConfigFlags_NoMouseCursorChange;
  const std::string font = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  static const ImWchar glyphs[] = {0x20, 0xff, 0x2013, 0x2026, 0x2190, 0x2193, 0};
  if (std::filesystem::exists(font)) io.Fonts->AddFontFromFileTTF(font.c_str(), 14.0F, nullptr, glyphs);
  set_style();
  // ImGui calls the callbacks that were set before its own.
  glfwSetWindowUserPointer(window_, this);
  glfwSetKeyCallback(window_, [](GLFWwindow* window, int code, int, int action, int mods) {
    if (action == GLFW_RELEASE) return;
    static_cast<Window*>(glfwGetWindowUserPointer(window))
        ->keys_.push_back({code, (mods & GLFW_MOD_SHIFT) != 0, action == GLFW_REPEAT});
  });
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL3_Init("#version 130");
}

Window::~Window() {
  glfwMakeContextCurrent(window_);
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

void Window::make_current() { glfwMakeContextCurrent(window_); }
void* Window::function(const char* name) const { return reinterpret_cast<void*>(glfwGetProcAddress(name)); }

void Window::publish() {
  for (const char* known : {"eglGetProcAddress", "OSMesaGetProcAddress", "glXGetProcAddressARB"}) {
    if (dlsym(RTLD_DEFAULT, known) != nullptr) return;
  }
  if (dlopen("libGL.so.1", RTLD_NOW | RTLD_GLOBAL) == nullptr)
    throw RunError(std::string("no OpenGL: ") + dlerror());
}

bool Window::closed() const { return glfwWindowShouldClose(window_) == GLFW_TRUE; }
void Window::close() { glfwSetWindowShouldClose(window_, GLFW_TRUE); }
void Window::keep_open() { glfwSetWindowShouldClose(window_, GLFW_FALSE); }
void Window::hide() {
  glfwHideWindow(window_);
  glfwPollEvents();
}

int Window::width() const {
  int width = 0;
  glfwGetFramebufferSize(window_, &width, nullptr);
  return width;
}
int Window::height() const {
  int height = 0;
  glfwGetFramebufferSize(window_, nullptr, &height);
  return height;
}

void Window::begin(double timeout_s) {
  keys_.clear();
  if (timeout_s > 0.0) {
    glfwWaitEventsTimeout(timeout_s);
  } else {
    glfwPollEvents();
  }
  glfwMakeContextCurrent(window_);
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  if (ImGui::GetIO().WantTextInput) keys_.clear();
}

void Window::end(cv::Mat* grab) {
  ImGui::Render();
  glfwMakeContextCurrent(window_);
  gl_->bind_framebuffer(GL_FRAMEBUFFER, 0);
  // MuJoCo leaves these enabled.
  gl_->disable(GL_LIGHTING);
  gl_->disable(GL_SCISSOR_TEST);
  gl_->viewport(0, 0, width(), height());
  gl_->clear_color(0.125F, 0.125F, 0.1325F, 1.0F);  // ground of the panels
  gl_->clear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  if (grab != nullptr) {
    cv::Mat upside_down(height(), width(), CV_8UC3);
    gl_->pixel_store(GL_PACK_ALIGNMENT, 1);
    gl_->read_pixels(0, 0, width(), height(), GL_BGR, GL_UNSIGNED_BYTE, upside_down.data);
    cv::flip(upside_down, *grab, 0);
  }
  glfwSwapBuffers(window_);
}

Window::Texture::Texture(Window& window, bool smooth) : window_(window) {
  window_.make_current();
  window_.gl_->gen_textures(1, &name_);
  window_.gl_->bind_texture(GL_TEXTURE_2D, name_);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    window_.gl_->tex_parameter(GL_TEXTURE_2D, filter, smooth ? GL_LINEAR : GL_NEAREST);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    window_.gl_->tex_parameter(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
}

Window::Texture::~Texture() {
  window_.make_current();
  window_.gl_->delete_textures(1, &name_);
}

void Window::Texture::set(ImageSize size, std::span<const std::uint8_t> rgb) {
  SACCADE_CHECK(rgb.size() == 3 * static_cast<std::size_t>(size.pixels()));
  window_.make_current();
  window_.gl_->bind_texture(GL_TEXTURE_2D, name_);
  window_.gl_->pixel_store(GL_UNPACK_ALIGNMENT, 1);
  if (size == size_) {
    window_.gl_->tex_sub_image(GL_TEXTURE_2D, 0, 0, 0, size.width, size.height, GL_RGB, GL_UNSIGNED_BYTE,
                               rgb.data());
    return;
  }
  window_.gl_->tex_image(GL_TEXTURE_2D, 0, GL_RGB8, size.width, size.height, 0, GL_RGB, GL_UNSIGNED_BYTE,
                         rgb.data());
  size_ = size;
}

void* Window::Texture::id() const { return reinterpret_cast<void*>(static_cast<std::uintptr_t>(name_)); }

}  // namespace saccade
