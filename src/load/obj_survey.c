// SPDX-License-Identifier: Apache-2.0
// Cuts an OBJ file into pieces at ends of lines and counts what is in each, so that all have their places before any is read.
#include "base/size.h"
#include "load/obj.h"
#include "load/text.h"

enum { PIECES_BETWEEN_PROGRESS = 64 };

// ------------------------------------------------------------------------------------------------------------- pieces

// Whether a line begins at `at`, whatever stands in the line before: after an end of a line that no backslash joins. There are three
// bytes before it and one behind.
static bool begins_line(const unsigned char *at)
{
    if (at[-1] == '\n') {
        return at[-2] == '\r' ? at[-3] != '\\' : at[-2] != '\\';
    }
    return at[-1] == '\r' && at[0] != '\n' && at[-2] != '\\';
}

// The first such place from `from` (at least 3) on, or the file's end.
static clast_status find_cut(const clast_obj *obj, uint64_t from, uint64_t *cut)
{
    enum { LOOK = 4096, BEFORE = 3 };
    unsigned char room[LOOK];
    uint64_t size = obj->file->size;
    while (from < size) {
        uint64_t begin = from - BEFORE;
        size_t length = size - begin < LOOK ? (size_t)(size - begin) : LOOK;
        const unsigned char *bytes;
        clast_status status = clast_file_piece(obj->file, begin, length, room, &bytes);
        if (status != CLAST_OK) {
            return clast_fail(obj->context, status, "%s: %s", obj->path, clast_status_text(status));
        }
        for (size_t i = BEFORE; i < length; i++) {
            if (begins_line(bytes + i)) {
                *cut = begin + i;
                return CLAST_OK;
            }
        }
        from = begin + length;
    }
    *cut = size;
    return CLAST_OK;
}

static clast_status cut_pieces(clast_obj *obj, size_t piece_size)
{
    uint64_t begin = 0, size = obj->file->size;
    while (begin < size) {
        uint64_t end = size;
        clast_status status = size - begin > piece_size ? find_cut(obj, begin + piece_size, &end) : CLAST_OK;
        if (status == CLAST_OK && end - begin > SIZE_MAX / 2) {
            status = clast_fail(obj->context, CLAST_ERROR_LIMIT, "%s: a line is too long for memory", obj->path);
        }
        if (status == CLAST_OK) {
            status = CLAST_RESERVE(obj->context, obj->pieces, obj->piece_capacity, obj->piece_count + 1);
        }
        if (status != CLAST_OK) {
            return status;
        }
        obj->pieces[obj->piece_count++] = (clast_obj_piece){.begin = begin, .end = end};
        begin = end;
    }
    return CLAST_OK;
}

clast_status clast_obj_look_at(const clast_obj *obj, size_t piece, uint32_t worker, clast_text *text)
{
    const clast_obj_piece *p = &obj->pieces[piece];
    clast_obj_window *window = &obj->windows[worker];
    size_t size = (size_t)(p->end - p->begin);
    const unsigned char *bytes = window->window.room;
    if (obj->file->descriptor < 0 || window->piece != piece) {
        window->piece = SIZE_MAX;
        clast_status status = clast_file_look(obj->file, &window->window, p->begin, size, &bytes);
        if (status != CLAST_OK) {
            return status;
        }
        window->piece = piece;
    }
    *text = (clast_text){(const char *)bytes, (const char *)bytes + size, 1};
    if (p->begin == 0) {
        *text = clast_text_of((clast_bytes){bytes, size});
    }
    return CLAST_OK;
}

clast_status clast_obj_walk_pieces(clast_obj *obj, clast_range_function function, int step)
{
    clast_obj_walk walk = {obj, 0};
    clast_status status = CLAST_OK;
    while (status == CLAST_OK && walk.first < obj->piece_count) {
        size_t left = obj->piece_count - walk.first;
        size_t some = left < PIECES_BETWEEN_PROGRESS ? left : PIECES_BETWEEN_PROGRESS;
        clast_parallel_for(obj->context, some, 1, function, &walk);
        walk.first += some;
        if (obj->piece_count > PIECES_BETWEEN_PROGRESS) {
            uint64_t size = obj->file->size;
            status = clast_progress(obj->context, "load", obj->pieces[walk.first - 1].end + (uint64_t)step * size,
                                    2 * size);
        }
    }
    return status;
}

// -------------------------------------------------------------------------------------------------------------- counts

typedef struct surveyor {
    clast_obj *obj;
    clast_obj_piece *piece;
    clast_text text;
    bool is_plain; // lines end by LF, and none are joined
    bool has_object;
} surveyor;

static void next_line(surveyor *survey)
{
    if (!survey->is_plain) {
        clast_next_line(&survey->text);
        return;
    }
    const char *at = survey->text.at, *end = survey->text.end;
    const char *found = memchr(at, '\n', (size_t)(end - at));
    survey->text.at = found != NULL ? found + 1 : end;
}

// The form of the corner at hand, which ends at a blank, as a text: "7/7/7" gives one number thrice.
static uint8_t survey_corner(surveyor *survey)
{
    clast_word parts[3] = {{NULL, 0}, {NULL, 0}, {NULL, 0}};
    clast_word word = clast_next_word(&survey->text);
    const char *at = word.begin, *end = word.begin + word.length;
    for (int i = 0; i < 3; i++) {
        parts[i].begin = at;
        while (at < end && *at != '/') {
            at++;
        }
        parts[i].length = (size_t)(at - parts[i].begin);
        at += at < end;
    }
    uint8_t form = CLAST_OBJ_KNOWN;
    for (int i = 1; i < 3; i++) {
        if (parts[i].length != 0) {
            form |= i == 1 ? CLAST_OBJ_COORDINATES : CLAST_OBJ_NORMALS;
            // What counts backwards depends on how many there are of each.
            bool alike = parts[i].length == parts[0].length && parts[0].begin[0] != '-' &&
                         memcmp(parts[i].begin, parts[0].begin, parts[0].length) == 0;
            form |= alike ? 0 : CLAST_OBJ_UNLIKE;
        }
    }
    return form;
}

// A new span, where the face is the first of its object in the piece.
static clast_status find_span(surveyor *survey, clast_obj_span **span)
{
    clast_obj_piece *piece = survey->piece;
    if (piece->span_count == 0 || survey->has_object) {
        clast_status status = CLAST_RESERVE(survey->obj->context, piece->spans, piece->span_capacity,
                                            piece->span_count + 1);
        if (status != CLAST_OK) {
            return status;
        }
        piece->spans[piece->span_count++] = (clast_obj_span){
            .piece = (uint32_t)(piece - survey->obj->pieces),
            .begins_object = survey->has_object,
            .first_face = (uint32_t)piece->face_count,
        };
        survey->has_object = false;
    }
    *span = &piece->spans[piece->span_count - 1];
    return CLAST_OK;
}

static clast_status survey_face(surveyor *survey)
{
    size_t count = 0;
    uint8_t form = 0;
    while (!clast_line_is_over(&survey->text)) {
        form = clast_obj_join_forms(form, survey_corner(survey));
        count++;
    }
    if (count < 3 || survey->piece->face_count >= CLAST_NONE) {
        return CLAST_OK;
    }
    clast_obj_span *span;
    clast_status status = find_span(survey, &span);
    if (status == CLAST_OK) {
        bool is_alike = count < CLAST_NONE && (span->face_count == 0 || span->face_corners == count);
        span->face_corners = is_alike ? (uint32_t)count : 0;
        span->form = clast_obj_join_forms(span->form, form);
        span->face_count++;
        span->corner_count += count;
        span->triangle_count += count - 2;
        survey->piece->face_count++;
    }
    return status;
}

static clast_status survey_line(surveyor *survey)
{
    clast_word word = clast_next_word(&survey->text);
    char first = word.begin[0], second = word.length == 2 ? word.begin[1] : '\0';
    if (word.length <= 2 && first == 'v') {
        survey->piece->position_count += second == '\0';
        survey->piece->coordinate_count += second == 't';
        survey->piece->normal_count += second == 'n';
    } else if (clast_word_is(word, "f") || clast_word_is(word, "fo")) {
        return survey_face(survey);
    } else if (clast_word_is(word, "o")) {
        survey->has_object = true;
        clast_rest_of_line(&survey->text);
    } else if (clast_word_is(word, "usemtl") || clast_word_is(word, "mtllib")) {
        clast_rest_of_line(&survey->text); // names are not joined
    }
    return CLAST_OK;
}

static void survey_piece(clast_obj *obj, size_t number, uint32_t worker)
{
    clast_obj_piece *piece = &obj->pieces[number];
    surveyor survey = {.obj = obj, .piece = piece};
    clast_status status = clast_obj_look_at(obj, number, worker, &survey.text);
    if (status == CLAST_OK) {
        size_t size = (size_t)(survey.text.end - survey.text.at);
        survey.is_plain = memchr(survey.text.at, '\r', size) == NULL && memchr(survey.text.at, '\\', size) == NULL;
    }
    while (status == CLAST_OK && survey.text.at < survey.text.end) {
        if (!clast_line_is_over(&survey.text)) {
            status = survey_line(&survey);
        }
        next_line(&survey);
    }
    piece->ends_with_object = survey.has_object;
    piece->error.status = status;
}

static void survey_pieces(void *data, size_t begin, size_t end, uint32_t worker)
{
    clast_obj_walk *walk = data;
    for (size_t i = begin; i < end; i++) {
        survey_piece(walk->obj, walk->first + i, worker);
    }
}

// -------------------------------------------------------------------------------------------------------------- places

static clast_status begin_object(clast_obj *obj)
{
    clast_status status = CLAST_RESERVE(obj->context, obj->objects, obj->object_capacity, obj->object_count + 1);
    if (status == CLAST_OK) {
        obj->objects[obj->object_count++] = (clast_obj_object){.first_span = obj->span_count};
    }
    return status;
}

// Gives the spans of a piece their places in objects; `has_object`: an `o` stands before the piece, behind the last face.
static clast_status place_spans(clast_obj *obj, clast_obj_piece *piece, bool has_object)
{
    piece->first_span = obj->span_count;
    clast_status status = CLAST_RESERVE(obj->context, obj->spans, obj->span_capacity,
                                        obj->span_count + piece->span_count);
    for (size_t i = 0; status == CLAST_OK && i < piece->span_count; i++) {
        clast_obj_span *span = &piece->spans[i];
        if (span->begins_object || has_object || obj->object_count == 0) {
            status = begin_object(obj);
        }
        if (status == CLAST_OK) {
            has_object = false;
            clast_obj_object *object = &obj->objects[obj->object_count - 1];
            span->object = (uint32_t)(obj->object_count - 1);
            span->first_corner = (size_t)object->corner_count;
            span->first_triangle = (size_t)object->triangle_count;
            object->form = clast_obj_join_forms(object->form, span->form);
            object->face_count += span->face_count;
            object->corner_count += span->corner_count;
            object->triangle_count += span->triangle_count;
            object->span_count++;
            obj->spans[obj->span_count++] = *span;
        }
    }
    clast_free(obj->context, piece->spans);
    piece->spans = NULL;
    return status;
}

static clast_status place_pieces(clast_obj *obj)
{
    bool has_object = false;
    size_t face_count = 0;
    for (size_t i = 0; i < obj->piece_count; i++) {
        clast_obj_piece *piece = &obj->pieces[i];
        piece->first_position = obj->position_count;
        piece->first_coordinate = obj->coordinate_count;
        piece->first_normal = obj->normal_count;
        piece->first_face = face_count;
        obj->position_count += piece->position_count;
        obj->coordinate_count += piece->coordinate_count;
        obj->normal_count += piece->normal_count;
        face_count += piece->face_count;
        bool had_none = piece->span_count == 0;
        clast_status status = place_spans(obj, piece, has_object);
        if (status != CLAST_OK) {
            return status;
        }
        has_object = piece->ends_with_object || (had_none && has_object);
    }
    return CLAST_OK;
}

// The arrays of exactly as much as there is. Beyond CLAST_NONE reading ends with an error.
static clast_status allocate_arrays(clast_obj *obj)
{
    clast_context *context = obj->context;
    size_t most = CLAST_NONE;
    size_t positions = obj->position_count < most ? obj->position_count : most;
    size_t coordinates = obj->coordinate_count < most ? obj->coordinate_count : most;
    size_t normals = obj->normal_count < most ? obj->normal_count : most;
    bool whole = (obj->positions = clast_allocate(context, positions, sizeof *obj->positions)) != NULL &&
                 (obj->coordinates = clast_allocate(context, coordinates, sizeof *obj->coordinates)) != NULL &&
                 (obj->normals = clast_allocate(context, normals, sizeof *obj->normals)) != NULL;
    for (size_t i = 0; whole && i < obj->object_count; i++) {
        clast_obj_object *object = &obj->objects[i];
        bool unlike = (object->form & CLAST_OBJ_UNLIKE) != 0;
        size_t count = (size_t)object->corner_count;
        whole = (object->positions = clast_allocate(context, count, sizeof *object->positions)) != NULL;
        if (whole && unlike && (object->form & CLAST_OBJ_COORDINATES) != 0) {
            whole = (object->coordinates = clast_allocate(context, count, sizeof *object->coordinates)) != NULL;
        }
        if (whole && unlike && (object->form & CLAST_OBJ_NORMALS) != 0) {
            whole = (object->normals = clast_allocate(context, count, sizeof *object->normals)) != NULL;
        }
    }
    return whole ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

clast_status clast_obj_survey(clast_obj *obj, size_t piece_size)
{
    clast_status status = cut_pieces(obj, piece_size);
    if (status == CLAST_OK) {
        status = clast_obj_walk_pieces(obj, survey_pieces, 0);
    }
    for (size_t i = 0; status == CLAST_OK && i < obj->piece_count; i++) {
        status = obj->pieces[i].error.status;
        if (status == CLAST_ERROR_FILE_READ) {
            return clast_fail(obj->context, status, "%s: %s", obj->path, clast_status_text(status));
        }
    }
    if (status == CLAST_OK) {
        status = place_pieces(obj);
    }
    return status == CLAST_OK ? allocate_arrays(obj) : status;
}
