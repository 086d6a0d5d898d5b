// Draws a mesh of ours with OpenGL on the CPU (EGL without a window system, Mesa's llvmpipe): the
// views, the size and the light of pxpl5, pixels read back to memory.
//
// usage: egl_peer MESH.ply WIDTHxHEIGHT X Y Z RADIUS [COUNT]
//   X Y Z RADIUS   sphere around the volume, mm; our camera stands off so that it is seen whole
// Prints one JSON line. LP_NUM_THREADS says how many threads llvmpipe uses.
#define GL_GLEXT_PROTOTYPES
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#include <GL/glext.h>
#include <fmt/core.h>

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/scene/camera.hpp"
#include "tests/bench/peers/ply.hpp"

using namespace pxpl5;

namespace {

constexpr int warm_up = 10;
constexpr int usual_count = 60, max_count = 100'000;
constexpr int max_side_px = 8192;
constexpr double step_deg = 3.6;

constexpr const char* vertex_shader = R"(#version 330 core
layout(location = 0) in vec3 p_mm;
layout(location = 1) in vec3 normal;
uniform mat4 patient_to_eye, projection;
out vec3 n_eye;
void main() {
    n_eye = mat3(patient_to_eye) * normal;
    gl_Position = projection * (patient_to_eye * vec4(p_mm, 1));
})";

// Two directional lights and Phong per pixel, normals turned to the viewer, as we draw.
constexpr const char* fragment_shader = R"(#version 330 core
in vec3 n_eye;
out vec4 color;
const vec3 directions[2] = vec3[2](vec3(-0.398, 0.530, 0.749), vec3(0.811, -0.139, 0.568));
const float intensities[2] = float[2](0.72, 0.26);
void main() {
    vec3 n = normalize(n_eye);
    if (n.z < 0) n = -n;
    float diffuse = 0.16, gloss = 0;
    for (int i = 0; i < 2; ++i) {
        diffuse += intensities[i] * max(dot(n, directions[i]), 0);
        vec3 h = normalize(directions[i] + vec3(0, 0, 1));
        gloss += intensities[i] * pow(max(dot(n, h), 0), 24);
    }
    color = vec4(vec3(0.93, 0.89, 0.78) * diffuse + 0.25 * gloss, 1);
})";

struct Wish {
    std::string mesh;
    int width_px = 0, height_px = 0;
    host::Subject subject;
    int count = usual_count;
};

void require(bool good, const std::string& what) {
    if (!good) {
        throw std::runtime_error(what);
    }
}

Wish parse(int argc, char** argv) {
    Wish wish;
    wish.mesh = argv[1];
    require(std::sscanf(argv[2], "%dx%d", &wish.width_px, &wish.height_px) == 2,
            "the size is WIDTHxHEIGHT");
    require(wish.width_px > 0 && wish.width_px <= max_side_px && wish.height_px > 0 &&
                wish.height_px <= max_side_px,
            fmt::format("width and height are 1 .. {}", max_side_px));
    for (int axis = 0; axis < 3; ++axis) {
        wish.subject.center_mm[axis] = std::stod(argv[3 + axis]);
    }
    wish.subject.radius_mm = std::stod(argv[6]);
    require(wish.subject.radius_mm > 0, "RADIUS is above 0");
    if (argc == 8) {
        wish.count = std::stoi(argv[7]);
    }
    require(wish.count > 0 && wish.count <= max_count,
            fmt::format("COUNT is 1 .. {}, not {}", max_count, wish.count));
    return wish;
}

/// A context that needs no window, made current.
void open_context() {
    const auto get_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
        eglGetProcAddress("eglGetPlatformDisplayEXT"));
    require(get_display != nullptr, "EGL knows no platforms");
    const EGLDisplay display =
        get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    require(eglInitialize(display, nullptr, nullptr) == EGL_TRUE, "EGL cannot be initialized");
    require(eglBindAPI(EGL_OPENGL_API) == EGL_TRUE, "EGL has no OpenGL");
    const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                             EGL_NONE};
    EGLConfig config = nullptr;
    EGLint found = 0;
    require(eglChooseConfig(display, wanted, &config, 1, &found) == EGL_TRUE && found > 0,
            "EGL has no such configuration");
    const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3, EGL_NONE};
    const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, version);
    require(eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_TRUE,
            fmt::format("EGL gives no context: error {:#x}", eglGetError()));
}

GLuint shader(GLenum kind, const char* text) {
    const GLuint made = glCreateShader(kind);
    glShaderSource(made, 1, &text, nullptr);
    glCompileShader(made);
    GLint good = 0;
    glGetShaderiv(made, GL_COMPILE_STATUS, &good);
    require(good == GL_TRUE, "a shader does not compile");
    return made;
}

GLuint program() {
    const GLuint made = glCreateProgram();
    glAttachShader(made, shader(GL_VERTEX_SHADER, vertex_shader));
    glAttachShader(made, shader(GL_FRAGMENT_SHADER, fragment_shader));
    glLinkProgram(made);
    glUseProgram(made);
    return made;
}

void make_target(int width_px, int height_px) {
    GLuint target = 0, buffers[2]{};
    glGenFramebuffers(1, &target);
    glGenRenderbuffers(2, buffers);
    glBindFramebuffer(GL_FRAMEBUFFER, target);
    const struct {
        GLenum format, place;
    } parts[2] = {{GL_RGBA8, GL_COLOR_ATTACHMENT0}, {GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT}};
    for (int i = 0; i < 2; ++i) {
        glBindRenderbuffer(GL_RENDERBUFFER, buffers[i]);
        glRenderbufferStorage(GL_RENDERBUFFER, parts[i].format, width_px, height_px);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, parts[i].place, GL_RENDERBUFFER, buffers[i]);
    }
    require(glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE,
            "the framebuffer is not complete");
    glViewport(0, 0, width_px, height_px);
    glEnable(GL_DEPTH_TEST);
    glClearColor(18 / 255.0F, 22 / 255.0F, 30 / 255.0F, 1);
}

void upload(const peer::Mesh& mesh) {
    GLuint array = 0, buffers[2]{};
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    glGenBuffers(2, buffers);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glBufferData(GL_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(mesh.vertices.size() * sizeof(peer::Vertex)),
                 mesh.vertices.data(), GL_STATIC_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(mesh.indices.size() * sizeof(std::uint32_t)),
                 mesh.indices.data(), GL_STATIC_DRAW);
    for (const GLuint place : {0U, 1U}) {
        const std::size_t offset = place == 0 ? 0 : offsetof(peer::Vertex, normal);
        glEnableVertexAttribArray(place);
        glVertexAttribPointer(place, 3, GL_FLOAT, GL_FALSE, sizeof(peer::Vertex),
                              reinterpret_cast<const void*>(offset));
    }
}

struct View {
    GLint patient_to_eye, projection;
};

void draw(const Wish& wish, const View& view, double azimuth_deg, std::size_t indices) {
    host::Camera camera;
    camera.angles.azimuth_deg = azimuth_deg;
    const host::CameraMatrices matrices = host::camera_matrices(
        camera, wish.subject, static_cast<double>(wish.width_px) / wish.height_px);
    const glm::mat4 eye(matrices.patient_to_eye), projection(matrices.projection);
    glUniformMatrix4fv(view.patient_to_eye, 1, GL_FALSE, glm::value_ptr(eye));
    glUniformMatrix4fv(view.projection, 1, GL_FALSE, glm::value_ptr(projection));
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(indices), GL_UNSIGNED_INT, nullptr);
}

/// Times of all views after the warm-up, ms.
struct Samples {
    std::vector<double> wall;
    double cpu_mean = 0;  ///< Sum over all threads.
};

Samples measure(const Wish& wish, const peer::Mesh& mesh, std::vector<std::uint8_t>& pixels) {
    const GLuint made = program();
    const View view{glGetUniformLocation(made, "patient_to_eye"),
                    glGetUniformLocation(made, "projection")};
    Samples samples;
    std::clock_t cpu_start = 0;
    for (int i = 0; i < warm_up + wish.count; ++i) {
        if (i == warm_up) {
            cpu_start = std::clock();
        }
        const auto start = std::chrono::steady_clock::now();
        draw(wish, view, i * step_deg, mesh.indices.size());
        glReadPixels(0, 0, wish.width_px, wish.height_px, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
        const std::chrono::duration<double, std::milli> took =
            std::chrono::steady_clock::now() - start;
        if (i >= warm_up) {
            samples.wall.push_back(took.count());
        }
    }
    samples.cpu_mean =
        1000.0 * static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC / wish.count;
    return samples;
}

/// Pixels that are not background: a peer that draws nothing would be quick.
std::size_t covered(const std::vector<std::uint8_t>& pixels) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < pixels.size(); i += 4) {
        count += pixels[i] != 18 || pixels[i + 1] != 22 || pixels[i + 2] != 30 ? 1 : 0;
    }
    return count;
}

void run(const Wish& wish) {
    const peer::Mesh mesh = peer::read_ply(wish.mesh);
    open_context();
    make_target(wish.width_px, wish.height_px);
    upload(mesh);
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(wish.width_px) *
                                     static_cast<std::size_t>(wish.height_px) * 4);
    const Samples samples = measure(wish, mesh, pixels);
    require(covered(pixels) > 0, "the picture is empty");
    std::string list;
    for (const double sample : samples.wall) {
        list += (list.empty() ? "" : ", ") + std::to_string(sample);
    }
    fmt::print(
        "{{\"work\": \"draw\", \"triangles\": {}, \"covered_px\": {}, \"backend\": \"{}\", "
        "\"cpu_ms\": {:.3f}, \"ms\": [{}]}}\n",
        mesh.indices.size() / 3, covered(pixels),
        reinterpret_cast<const char*>(glGetString(GL_RENDERER)), samples.cpu_mean, list);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 7 && argc != 8) {
        fmt::print(stderr, "usage: egl_peer MESH.ply WIDTHxHEIGHT X Y Z RADIUS [COUNT]\n");
        return 64;
    }
    try {
        run(parse(argc, argv));
    } catch (const std::exception& error) {
        fmt::print(stderr, "error: {}\n", error.what());
        return 1;
    }
    return 0;
}
