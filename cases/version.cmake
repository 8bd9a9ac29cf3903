# Writes the header with the version: TALUS_VERSION and, in a checkout, the commit it was built from. Called by the
# build with -DSOURCE, -DVERSION, -DOUTPUT. The header is touched only when its text changes.
set(commit "")
if(EXISTS "${SOURCE}/.git")
  find_program(GIT git)
  if(GIT)
    execute_process(COMMAND "${GIT}" -C "${SOURCE}" describe --tags --always --dirty --match "v${VERSION}" --abbrev=10
                    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
    if(failed OR commit STREQUAL "v${VERSION}")  # at the tag of this version the number says it all
      set(commit "")
    elseif(NOT commit STREQUAL "")
      string(REGEX REPLACE "^v${VERSION}-" "" commit "${commit}")
      set(commit "+${commit}")
    endif()
  endif()
endif()
set(text "#pragma once\n#define TALUS_FULL_VERSION TALUS_VERSION \"${commit}\"\n")
set(before "")
if(EXISTS "${OUTPUT}")
  file(READ "${OUTPUT}" before)
endif()
if(NOT text STREQUAL before)
  file(WRITE "${OUTPUT}" "${text}")
endif()
