#pragma once
/// Takes out of a framebuffer what OpenGL has drawn: at once, or through buffers, so that a graphics card draws the
/// next picture meanwhile.
#include "render/gl/handles.h"
#include "render/picture/depth_picture.h"
#include "render/picture/edges.h"

#include <deque>

namespace render {

class PictureReader {
public:
    PictureReader() = default;
    /// width, height [px]; reads_ids: part numbers too, the second colour of the framebuffer.
    PictureReader(int width, int height, bool reads_ids, bool is_buffered);

    /// Pictures that may be begun while none is finished, >= 1.
    int capacity() const { return is_buffered_ ? 2 : 1; }

    /// A rectangle of the picture in the framebuffer that is bound now, and the depths of the whole picture;
    /// `capacity()` at most are begun and not finished: CHECK.
    void begin(const glm::mat4& clip_from_world, const PixelRect& rect, bool has_depth);

    /// The first that was begun and not finished; if it is not buffered, its framebuffer still is bound. depth: filled
    /// if begin() asked for it.
    void finish(RawPicture& raw, DepthPicture& depth);

private:
    struct Begun {
        glm::mat4 clip_from_world{1.0f};
        PixelRect rect{};
        bool has_depth = false;
        GlBuffer color{};
        GlBuffer ids{};
        GlBuffer depth{};
    };

    /// What is read: of which pixels, and how told.
    struct Read {
        PixelRect rect;
        GLenum format;
        GLenum type;

        std::size_t bytes() const;
        void into(void* to) const;
    };

    template <class Value>
    void take(const GlBuffer& buffer, const Read& read, std::vector<Value>& values) const;
    void start(GlBuffer& buffer, const Read& read) const;
    PixelRect whole() const { return {0, 0, width_, height_}; }

    int width_ = 0;
    int height_ = 0;
    bool reads_ids_ = false;
    bool is_buffered_ = false;
    std::deque<Begun> begun_;
    std::deque<Begun> free_; ///< whose buffers are used again
};

} // namespace render
