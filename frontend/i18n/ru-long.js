// @ts-check
// Russian for what long recordings bring: what a result keeps, what charts of many targets leave out.

/** @type {Record<string, string>} */
export const words = {
  "lower triangle of the state's covariance row by row (45 elements), or of the position's alone (6): of one-mark solutions, and of filters over more than 100,000 marks": "нижний треугольник ковариации состояния по строкам (45 элементов) или только координат (6): у решений по одной отметке и у фильтров при более чем 100 000 отметок",
  "products of the state's units": "произведения единиц состояния",
};

/** @type {Record<string, string>} */
export const sentences = {
  "Of each covariance the position's part alone is kept: the recording has more than 100,000 marks.": "Из каждой ковариации сохранена только часть координат: в записи более 100 000 отметок.",
};
