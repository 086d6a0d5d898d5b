# cmake -DINPUT=file.bfbs -DOUTPUT=file.inc -P embed_schema.cmake
# Writes the bytes of a binary schema as the elements of an array.
file(READ ${INPUT} bytes HEX)
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
file(WRITE ${OUTPUT} "${bytes}\n")
