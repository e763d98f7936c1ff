// @ts-check
// Russian for interacting models on marks.

/** @type {Record<string, string>} */
export const words = {
  "Interacting models on marks": "Взаимодействующие модели по отметкам",
  "The recommended filter: straight flight and manoeuvre interact, the altitude's bias is estimated, and a late reception is left out.": "Рекомендуемый фильтр: прямолинейный полёт и манёвр взаимодействуют, смещение высоты оценивается, запоздавший приём отбрасывается.",
  "of straight flight and of manoeuvre": "прямолинейного полёта и манёвра",
  "straight flight": "прямолинейный полёт",
  "manoeuvre": "манёвр",
  "decoded altitude less geometric height, as estimated": "принятая высота минус геометрическая, оценка",
  "its standard deviation": "её среднеквадратическое отклонение",
  "What is done with the decoded altitude.": "Что делать с принятой высотой.",
  "used; its slowly changing difference from the geometric height is estimated": "берётся; её медленно меняющееся отличие от геометрической высоты оценивается",
  "used; its errors are taken for independent from mark to mark": "берётся; её ошибки считаются независимыми от отметки к отметке",
  "Standard deviation of the difference between decoded altitude and geometric height, where it is estimated. Pressure altitude differs from the geometric height by 50-300 m; a bias three times larger than said is still followed.": "СКО разности принятой и геометрической высоты, если она оценивается. Барометрическая высота отличается от геометрической на 50–300 м; фильтр справляется и со смещением, втрое большим заданного.",
  "Time of the bias": "Время смещения",
  "Time in which the bias is forgotten to 1/e.": "Время, за которое смещение забывается в e раз.",
  "Share of good marks that pass the gate.": "Доля исправных отметок, проходящих строб.",
  "Acceleration of straight flight": "Ускорение прямолинейного полёта",
  "Standard deviation of the acceleration that disturbs the straight flight.": "СКО ускорения, возмущающего прямолинейный полёт.",
  "Jerk of the manoeuvre": "Рывок манёвра",
  "Standard deviation of the jerk that disturbs the manoeuvre.": "СКО рывка, возмущающего манёвр.",
  "Form of the manoeuvre's process noise.": "Вид шума движения при манёвре.",
  "Straight flight lasts": "Длительность прямолинейного полёта",
  "Mean time for which a flight stays straight.": "Среднее время, в течение которого полёт остаётся прямолинейным.",
  "Manoeuvre lasts": "Длительность манёвра",
  "Mean time of a manoeuvre.": "Среднее время манёвра.",
  "one reception was left out: the others agree without it": "один приём отброшен: остальные без него согласуются",
  "the altitude was left out: the receptions agree without it": "высота отброшена: приёмы без неё согласуются",
};

/** @type {[RegExp, string][]} */
export const patterns = [
  [/^one reception was left out: the others agree without it; station (.+)$/, "один приём отброшен: остальные без него согласуются; пункт $1"],
];
