#pragma once
/// OpenGL's functions: of the library whose context is current in this thread. A function that is not in this list
/// does not compile.
#include <GL/glcorearb.h>

namespace render {

/// Calls X(name, type) for each function.
#define GL_FUNCTIONS(X) \
    X(glActiveTexture, PFNGLACTIVETEXTUREPROC) \
    X(glAttachShader, PFNGLATTACHSHADERPROC) \
    X(glBindBuffer, PFNGLBINDBUFFERPROC) \
    X(glBindBufferBase, PFNGLBINDBUFFERBASEPROC) \
    X(glBindFramebuffer, PFNGLBINDFRAMEBUFFERPROC) \
    X(glBindRenderbuffer, PFNGLBINDRENDERBUFFERPROC) \
    X(glBindTexture, PFNGLBINDTEXTUREPROC) \
    X(glBindVertexArray, PFNGLBINDVERTEXARRAYPROC) \
    X(glBufferData, PFNGLBUFFERDATAPROC) \
    X(glCheckFramebufferStatus, PFNGLCHECKFRAMEBUFFERSTATUSPROC) \
    X(glClear, PFNGLCLEARPROC) \
    X(glClearDepth, PFNGLCLEARDEPTHPROC) \
    X(glClipControl, PFNGLCLIPCONTROLPROC) \
    X(glCompileShader, PFNGLCOMPILESHADERPROC) \
    X(glCreateProgram, PFNGLCREATEPROGRAMPROC) \
    X(glCreateShader, PFNGLCREATESHADERPROC) \
    X(glCullFace, PFNGLCULLFACEPROC) \
    X(glDeleteBuffers, PFNGLDELETEBUFFERSPROC) \
    X(glDeleteFramebuffers, PFNGLDELETEFRAMEBUFFERSPROC) \
    X(glDeleteProgram, PFNGLDELETEPROGRAMPROC) \
    X(glDeleteRenderbuffers, PFNGLDELETERENDERBUFFERSPROC) \
    X(glDeleteShader, PFNGLDELETESHADERPROC) \
    X(glDeleteTextures, PFNGLDELETETEXTURESPROC) \
    X(glDeleteVertexArrays, PFNGLDELETEVERTEXARRAYSPROC) \
    X(glDepthFunc, PFNGLDEPTHFUNCPROC) \
    X(glDepthMask, PFNGLDEPTHMASKPROC) \
    X(glDetachShader, PFNGLDETACHSHADERPROC) \
    X(glDrawBuffer, PFNGLDRAWBUFFERPROC) \
    X(glDrawBuffers, PFNGLDRAWBUFFERSPROC) \
    X(glDrawElements, PFNGLDRAWELEMENTSPROC) \
    X(glDrawElementsInstancedBaseInstance, PFNGLDRAWELEMENTSINSTANCEDBASEINSTANCEPROC) \
    X(glEnable, PFNGLENABLEPROC) \
    X(glEnableVertexAttribArray, PFNGLENABLEVERTEXATTRIBARRAYPROC) \
    X(glFlush, PFNGLFLUSHPROC) \
    X(glFramebufferRenderbuffer, PFNGLFRAMEBUFFERRENDERBUFFERPROC) \
    X(glFramebufferTexture2D, PFNGLFRAMEBUFFERTEXTURE2DPROC) \
    X(glGenBuffers, PFNGLGENBUFFERSPROC) \
    X(glGenFramebuffers, PFNGLGENFRAMEBUFFERSPROC) \
    X(glGenRenderbuffers, PFNGLGENRENDERBUFFERSPROC) \
    X(glGenTextures, PFNGLGENTEXTURESPROC) \
    X(glGenVertexArrays, PFNGLGENVERTEXARRAYSPROC) \
    X(glGetError, PFNGLGETERRORPROC) \
    X(glGetIntegerv, PFNGLGETINTEGERVPROC) \
    X(glGetProgramInfoLog, PFNGLGETPROGRAMINFOLOGPROC) \
    X(glGetProgramiv, PFNGLGETPROGRAMIVPROC) \
    X(glGetShaderInfoLog, PFNGLGETSHADERINFOLOGPROC) \
    X(glGetShaderiv, PFNGLGETSHADERIVPROC) \
    X(glGetString, PFNGLGETSTRINGPROC) \
    X(glGetUniformLocation, PFNGLGETUNIFORMLOCATIONPROC) \
    X(glLinkProgram, PFNGLLINKPROGRAMPROC) \
    X(glMapBufferRange, PFNGLMAPBUFFERRANGEPROC) \
    X(glPixelStorei, PFNGLPIXELSTOREIPROC) \
    X(glReadBuffer, PFNGLREADBUFFERPROC) \
    X(glReadPixels, PFNGLREADPIXELSPROC) \
    X(glRenderbufferStorage, PFNGLRENDERBUFFERSTORAGEPROC) \
    X(glScissor, PFNGLSCISSORPROC) \
    X(glShaderSource, PFNGLSHADERSOURCEPROC) \
    X(glTexBuffer, PFNGLTEXBUFFERPROC) \
    X(glTexImage2D, PFNGLTEXIMAGE2DPROC) \
    X(glTexImage3D, PFNGLTEXIMAGE3DPROC) \
    X(glTexParameterfv, PFNGLTEXPARAMETERFVPROC) \
    X(glTexParameteri, PFNGLTEXPARAMETERIPROC) \
    X(glUniform1f, PFNGLUNIFORM1FPROC) \
    X(glUniform1i, PFNGLUNIFORM1IPROC) \
    X(glUniform1ui, PFNGLUNIFORM1UIPROC) \
    X(glUniform2fv, PFNGLUNIFORM2FVPROC) \
    X(glUniform3fv, PFNGLUNIFORM3FVPROC) \
    X(glUniform4fv, PFNGLUNIFORM4FVPROC) \
    X(glUniformMatrix4fv, PFNGLUNIFORMMATRIX4FVPROC) \
    X(glUnmapBuffer, PFNGLUNMAPBUFFERPROC) \
    X(glUseProgram, PFNGLUSEPROGRAMPROC) \
    X(glVertexAttribDivisor, PFNGLVERTEXATTRIBDIVISORPROC) \
    X(glVertexAttribIPointer, PFNGLVERTEXATTRIBIPOINTERPROC) \
    X(glVertexAttribPointer, PFNGLVERTEXATTRIBPOINTERPROC) \
    X(glViewport, PFNGLVIEWPORTPROC)

#define GL_DECLARE(name, type) inline constinit thread_local type name = nullptr;
GL_FUNCTIONS(GL_DECLARE)
#undef GL_DECLARE

using GlFunction = void (*)();

/// find: gives the address of a function by its name, or null. Throws Error (io) naming the first that is missing.
void load_gl_functions(GlFunction (*find)(const char* name));

} // namespace render
