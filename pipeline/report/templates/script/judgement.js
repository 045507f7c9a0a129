// Whether an effect is there, by what leaving it out does to the fit that contains it.
function judge(triad, order, effect, out) {
  const added = order.includes(effect);
  const withIt = refitWithout(triad, added ? order : [...order, effect], out);
  const without = refitWithout(triad, order.filter((other) => other !== effect), out);
  const count = without.dof - withIt.dof, drop = Math.max(without.chi2 - withIt.chi2, 0);
  if (count < 1) return null;
  // Where noise does not explain what remains, that scatter is the measure, as for the sds.
  const misfit = withIt.p < MISFIT_P_VALUE, scale = misfit ? withIt.chi2 / withIt.dof : 1;
  const p = fTail(drop / count / scale, count, misfit ? withIt.dof : triad.noise_dof);
  const change = withIt.loo / without.loo - 1;
  return {
    effect, added, misfit, inSd: Math.sqrt(drop / count / scale), change,
    isThere: p < MISFIT_P_VALUE, helps: p < MISFIT_P_VALUE && change < 0 && withIt.dof >= FEWEST_DOF,
    determined: withIt.dof >= FEWEST_DOF,
  };
}

const percent = (share) => {
  const size = Math.abs(100 * share);
  return size >= 1000 ? `${short(1 + Math.abs(share))}-fold` : `by ${size >= 10 ? size.toFixed(0) : size.toPrecision(2)} %`;
};

function judgementText({ effect, added, misfit, inSd, change, isThere, determined }) {
  const size = `${effect.name}: ${inSd < 9.95 ? inSd.toFixed(1) : inSd.toFixed(0)} sd`;
  const loo = Math.abs(change) < 5e-4 ? "leave-one-out does not change"
    : `leave-one-out ${change > 0 ? "rises" : "falls"} ${percent(change)}`;
  if (!determined) return `${size}, but with it only so few degrees of freedom remain that this page cannot tell.`;
  if (effect.in_model && !added) {
    return isThere && change < 0 ? `${size}: it is there. With it ${loo}; keep it.`
      : `${size}: not there. With it ${loo}; remove it.`;
  }
  if (isThere && change < 0) return `${size}: it is there; ${loo}.`;
  if (isThere) return `${size}, but ${loo}: the model predicts worse with it.`;
  // Beside a large misfit an effect of a few sds can still turn out to be there.
  const doubtful = misfit && inSd > 1;
  return `${size}: ${doubtful ? "not seen beside what remains unexplained" : "not there"}; ${loo}.`;
}
