# cmake -DOUTPUT=file -DINPUTS="a.pxasm;b.pxasm" -P embed.cmake
# Writes each text as a constant named after its file: begin.pxasm becomes text::begin.
set(code "// Made by programs/embed.cmake from *.pxasm.\nnamespace text {\n")
foreach(input ${INPUTS})
    get_filename_component(name ${input} NAME_WE)
    file(READ ${input} text)
    string(APPEND code "constexpr std::string_view ${name} = R\"pxasm(${text})pxasm\";\n")
endforeach()
string(APPEND code "}  // namespace text\n")
file(WRITE ${OUTPUT} "${code}")
