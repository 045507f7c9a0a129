// The exact refits of a triad. A page that is opened as a file looks them up in its table; one that
// `pipeline open` serves asks for those of any set of effects, and without any poses.
class Refits {
  constructor(triad) {
    this.triad = triad;
    this.table = new Map(triad.refits.map((each) => [each.ticked.join(), each]));
  }

  // The refit with these effects in the table; undefined where it is not there.
  of(effects) {
    const places = effects.map((effect) => this.triad.effects.indexOf(effect));
    return this.table.get(places.sort((a, b) => a - b).join());
  }

  knows(effects) { return asks !== null || this.of(effects) !== undefined; }

  // ``show`` gets the refit with the effects in ``order``, and those with the first ones of them.
  find(order, out, show) {
    if (asks !== null) {
      asks("refit", { triad: this.triad.triad, ticked: order.map((effect) => effect.name), out: [...out],
        guesses: this.triad.effects.filter((effect) => effect.guess).map((effect) => effect.name) }).then(show, (error) => show({ failed: String(error.message ?? error) }));
      return;
    }
    show(this.inTable(order));
  }

  // The same from the table, as far as it goes.
  inTable(order) {
    const steps = [...order.keys(), order.length].map((k) => this.of(order.slice(0, k)));
    return { ...steps[order.length],
      steps: steps.every(Boolean) ? steps.map(({ chi2, dof }) => ({ chi2, dof })) : [] };
  }
}
