/* The version of the library. */

#include "native.h"

enum { VERSION = 6 }; /* as in compiled_library.py; a library left over from another version is not used */

API int64_t kinemark_native_version(void) { return VERSION; }
