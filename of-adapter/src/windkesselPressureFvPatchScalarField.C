/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "windkesselPressureFvPatchScalarField.H"
#include "fsiTimeScheme.H"
#include "fsiWindkessels.H"
#include "addToRunTimeSelectionTable.H"
#include "fvPatchFieldMapper.H"
#include "surfaceFields.H"
#include "volFields.H"

// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Foam::windkesselModel::windkesselModel(const dictionary& dict)
:
    resistance_(dict.get<scalar>("resistance")),
    compliance_(dict.get<scalar>("compliance")),
    proximalResistance_
    (
        dict.lookupOrDefault<scalar>("proximalResistance", 0)
    ),
    rampedFrom_(dict.lookupOrDefault<scalar>("rampedFrom", 0)),
    density_(dict.get<scalar>("density")),
    phiName_(dict.lookupOrDefault<word>("phi", "phi")),
    oldPressure_(dict.get<scalar>("pressure")),
    olderPressure_(dict.lookupOrDefault<scalar>("pressureBefore", 0)),
    stepBefore_(dict.lookupOrDefault<scalar>("stepBefore", 0))
{
    if (dict.found("distalPressure"))
    {
        distalPressure_.reset(Function1<scalar>::New("distalPressure", dict));
    }
    if (dict.found("ramp"))
    {
        ramp_.reset(Function1<scalar>::New("ramp", dict));
    }
    if
    (
        resistance_ < 0 || (resistance_ == 0 && compliance_ > 0)
     || compliance_ < 0 || proximalResistance_ < 0 || density_ <= 0
    )
    {
        FatalIOErrorInFunction(dict)
            << "A windkessel needs resistance > 0 (or 0 without compliance),"
            << " compliance >= 0, proximalResistance >= 0 and density > 0;"
            << " found " << resistance_ << ", " << compliance_ << ", "
            << proximalResistance_ << ", " << density_ << exit(FatalIOError);
    }
}


Foam::windkesselPressureFvPatchScalarField::windkesselPressureFvPatchScalarField
(
    const fvPatch& p,
    const DimensionedField<scalar, volMesh>& iF
)
:
    fixedValueFvPatchScalarField(p, iF)
{}


Foam::windkesselPressureFvPatchScalarField::windkesselPressureFvPatchScalarField
(
    const fvPatch& p,
    const DimensionedField<scalar, volMesh>& iF,
    const dictionary& dict
)
:
    fixedValueFvPatchScalarField(p, iF, dict, false),
    windkesselModel(dict)
{
    if (dict.found("value"))
    {
        fvPatchField<scalar>::operator=(scalarField("value", dict, p.size()));
    }
    else
    {
        const scalar factor =
            ramp_ ? ramp_->value(db().time().timeOutputValue()) : 1;
        fvPatchField<scalar>::operator=
        (
            (rampedFrom_ + factor*(oldPressure_ - rampedFrom_))/density_
        );
    }
}


Foam::windkesselPressureFvPatchScalarField::windkesselPressureFvPatchScalarField
(
    const windkesselPressureFvPatchScalarField& other,
    const fvPatch& p,
    const DimensionedField<scalar, volMesh>& iF,
    const fvPatchFieldMapper& mapper
)
:
    fixedValueFvPatchScalarField(other, p, iF, mapper),
    windkesselModel(other)
{}


Foam::windkesselPressureFvPatchScalarField::windkesselPressureFvPatchScalarField
(
    const windkesselPressureFvPatchScalarField& other,
    const DimensionedField<scalar, volMesh>& iF
)
:
    fixedValueFvPatchScalarField(other, iF),
    windkesselModel(other)
{}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

Foam::scalar Foam::windkesselPressureFvPatchScalarField::next
(
    const scalar dt,
    const scalar t,
    const scalar Q
) const
{
    const scalar distal = distalPressure_ ? distalPressure_->value(t) : 0;
    if (resistance_ <= 0)
    {
        return distal;
    }
    if (stepBefore_ <= 0 || !fsi::isBackward(internalField().mesh()))
    {
        return
            (oldPressure_*compliance_/dt + Q + distal/resistance_)
           /(compliance_/dt + 1/resistance_);
    }
    const fsi::backwardDifference rate(dt, stepBefore_);
    const scalar earlier =
        rate.last*oldPressure_ + rate.before*olderPressure_;
    return
        (Q + distal/resistance_ - compliance_*earlier)
       /(compliance_*rate.next + 1/resistance_);
}


Foam::scalar Foam::windkesselPressureFvPatchScalarField::lastTime() const
{
    const Time& time = db().time();
    return time.timeOutputValue() - time.deltaTValue();
}


void Foam::windkesselPressureFvPatchScalarField::advance()
{
    const label now = db().time().timeIndex();
    if (timeIndex_ == now)
    {
        return;
    }
    if (timeIndex_ >= 0)
    {
        // The flux is still that of the step before: nothing has been solved
        // since. Time::deltaT0 is how long that step was when it began.
        const scalar Q =
            gSum(patch().lookupPatchField<surfaceScalarField, scalar>(phiName_));
        const scalar finished = next(timeStep_, lastTime(), Q);
        olderPressure_ = oldPressure_;
        oldPressure_ = finished;
        stepBefore_ = timeStep_;
    }
    timeIndex_ = now;
}


Foam::scalar Foam::windkesselPressureFvPatchScalarField::pressure() const
{
    const Time& time = db().time();
    if (timeIndex_ != time.timeIndex())
    {
        return oldPressure_;
    }
    const scalar Q =
        gSum(patch().lookupPatchField<surfaceScalarField, scalar>(phiName_));

    return next(time.deltaTValue(), time.timeOutputValue(), Q);
}


Foam::scalar Foam::windkesselPressureFvPatchScalarField::localFlow() const
{
    return sum(patch().lookupPatchField<surfaceScalarField, scalar>(phiName_));
}


Foam::scalar Foam::windkesselPressureFvPatchScalarField::target
(
    const scalar Q
) const
{
    const Time& time = db().time();
    const scalar factor = ramp_ ? ramp_->value(time.timeOutputValue()) : 1;
    const scalar p =
        next(time.deltaTValue(), time.timeOutputValue(), Q)
      + proximalResistance_*Q;
    return (rampedFrom_ + factor*(p - rampedFrom_))/density_;
}


void Foam::windkesselPressureFvPatchScalarField::begin()
{
    advance();
    timeStep_ = db().time().deltaTValue();
}


void Foam::windkesselPressureFvPatchScalarField::updateCoeffs()
{
    if (updated())
    {
        return;
    }
    operator==(fsi::windkessels::pressure(*this));

    fixedValueFvPatchScalarField::updateCoeffs();
}


void Foam::windkesselPressureFvPatchScalarField::write(Ostream& os) const
{
    fvPatchScalarField::write(os);
    os.writeEntry("resistance", resistance_);
    os.writeEntry("compliance", compliance_);
    os.writeEntryIfDifferent<scalar>
    (
        "proximalResistance", 0, proximalResistance_
    );
    os.writeEntryIfDifferent<scalar>("rampedFrom", 0, rampedFrom_);
    os.writeEntry("density", density_);
    if (distalPressure_)
    {
        distalPressure_->writeData(os);
    }
    os.writeEntryIfDifferent<word>("phi", "phi", phiName_);
    if (ramp_)
    {
        ramp_->writeData(os);
    }
    os.writeEntry("pressure", pressure());
    // Of the step that ends with the field, if one does
    const bool ends = timeIndex_ == db().time().timeIndex();
    const scalar step = ends ? timeStep_ : stepBefore_;
    if (step > 0)
    {
        os.writeEntry("pressureBefore", ends ? oldPressure_ : olderPressure_);
        os.writeEntry("stepBefore", step);
    }
    writeEntry("value", os);
}


namespace Foam
{
    makePatchTypeField
    (
        fvPatchScalarField,
        windkesselPressureFvPatchScalarField
    );
}


// ************************************************************************* //
