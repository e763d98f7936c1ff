// @ts-check
// Russian for charts over trials, for what their absence is explained by, and for the blocks of trials in a log.

/** @type {Record<string, string>} */
export const words = {
  "No statistics over trials at each instant: the run has none, or none is finished yet.": "Статистики по реализациям в каждый момент нет: в расчёте её не бывает, или ни одна реализация ещё не готова.",
  "No track is lost: every instant after the start has an estimate in every trial.": "Ни одна трасса не потеряна: после начала оценка есть в каждый момент каждой реализации.",
  "This run varies no number.": "В этом расчёте ни одно число не меняется.",
  "The first algorithm is swept itself: no single one of its values is what the others gain over.": "Параметр первого алгоритма сам меняется: ни одно его значение не годится для сравнения с другими.",
  "One algorithm alone: there is nothing to compare it with.": "Алгоритм один: сравнить его не с чем.",
  "Root mean square over all instants and trials; bars are 95 % intervals.": "Среднеквадратичное по всем моментам и реализациям; отрезки – 95 % интервалы.",
  "95 % band of NEES, low": "95 % полоса NEES, нижняя граница",
  "95 % band of NEES, high": "95 % полоса NEES, верхняя граница",
};

/** Lines of a log. @type {Record<string, string>} */
export const sentences = {
  "Trials {1} to {2}": "Реализации с {1} по {2}",
};

/** @type {[RegExp, string][]} */
export const patterns = [
  [/^Root mean square over (.+?) trials?; bands are 95 % intervals; dotted is the claim\.$/, "Среднеквадратичное по реализациям, их $1; полосы – 95 % интервалы; точками – заявленная ошибка."],
  [/^Root mean square error of (.+?) over that of the others, on the same draws: 2 is half the error\.$/, "Среднеквадратичная ошибка $1, делённая на ошибку других при тех же шумах: 2 – ошибка вдвое меньше."],
  [/^Per degree of freedom over (.+?) trials?: 1 is honest, above the band the algorithm claims smaller errors than it makes\. NIS is dotted; the grey band is that of NEES\.$/, "На степень свободы, реализаций: $1; 1 – честно, выше полосы алгоритм заявляет ошибки меньше действительных. NIS – точками; серая полоса – для NEES."],
  [/^Of (.+?) trials?: an instant without an estimate after the track's start counts as lost\.$/, "Реализаций: $1; момент без оценки после начала трассы считается потерей."],
  [/^bound of (.+)$/, "нижняя граница для $1"],
];
